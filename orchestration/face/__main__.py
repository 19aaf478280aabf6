"""`python -m warmlink`: the command, where no script of it is on the path."""

from warmlink.orchestration.cli import main

if __name__ == "__main__":
    main()

"""`python -m warmlink`: the command, where no script of it is on the path."""

from warmlink.orchestration.cli import script

if __name__ == "__main__":
    script()

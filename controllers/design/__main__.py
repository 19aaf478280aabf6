"""Work out the laws' shipped parameter sets again: `python -m warmlink.controllers.design`."""

from warmlink.controllers.design.shipped import write_all

if __name__ == "__main__":
    for path in write_all():
        print(path)

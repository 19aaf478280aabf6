"""What other packages add to warmlink: components, laws, causes, master algorithms, commands, machines.

A package says so in its `pyproject.toml`, and needs no change here:

```toml
[project.entry-points."warmlink.components"]
cold_plate = "cold_plates.plate.component:COMPONENT"
```
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.cache import remembered

KINDS = {
    "components": "a Component",
    "laws": "a Component with the connectors of a compensator",
    "causes": "a package that holds one TOML file for each cause",
    "masters": "an Algorithm",
    "commands": "a function with the command's arguments and options",
    "machines": "a Machine",
}
"""What each kind of addition names."""


@dataclass(frozen=True)
class Plugin:
    """An addition: its kind, its name, its place, as `package.module:attribute`, and its package."""

    kind: str
    name: str
    place: str
    package: str

    @property
    def module(self) -> str:
        """Module that holds it."""
        return self.place.partition(":")[0]

    @property
    def attribute(self) -> str:
        """Its name in the module; empty if it is the module."""
        return self.place.partition(":")[2]

    def refused(self, why: str) -> InputError:
        """The error that an addition is refused with."""
        told = f"the package {self.package} adds it to warmlink's {self.kind} as {self.name}"
        return InputError(f"{self.place}: {told}: {why}; mend that package, or uninstall it")

    def load(self) -> Any:
        """What the package adds; raises InputError if its code does not work."""
        try:
            module = import_module(self.module)
            return getattr(module, self.attribute) if self.attribute else module
        except InputError:
            raise
        except (Exception, SystemExit) as fault:
            told = " ".join(str(fault).split())[:300]
            raise self.refused(f"does not load ({type(fault).__name__}: {told})") from fault


def plugins(kind: str) -> tuple[Plugin, ...]:
    """What other packages add of a kind of `KINDS`, by name; InputError if two have one name."""
    found = [each for each in installed() if each.kind == kind]
    for one, other in pairwise(found):
        if one.name == other.name:
            raise other.refused(f"{one.package} adds another one of this name")
    return tuple(found)


@cache
def installed() -> tuple[Plugin, ...]:
    """What other packages add, of all kinds."""
    # Folders of packages change when one is installed; to read what all of them declare takes 20 ms.
    paths = [Path(each) for each in sys.path if each]
    folders = [(str(path), path.stat().st_mtime_ns) for path in paths if path.is_dir()]
    return remembered("plugins", folders, _declared)


def _declared() -> tuple[Plugin, ...]:
    from importlib.metadata import entry_points

    every = entry_points()
    return tuple(
        sorted(
            {
                Plugin(kind, each.name, each.value, each.dist.name if each.dist else "")
                for kind in KINDS
                for each in every.select(group=f"warmlink.{kind}")
            },
            key=lambda each: (each.kind, each.name, each.package),
        )
    )

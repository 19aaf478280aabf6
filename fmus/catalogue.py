"""The components that exist: every folder with a file `component.py` is one."""

import importlib
import importlib.util
import pkgutil
from dataclasses import dataclass
from pathlib import Path

from warmlink.fmus.component import Component

HOMES = ("warmlink.fmus", "warmlink.controllers")
"""Packages whose folders are searched."""


@dataclass(frozen=True)
class Entry:
    """A component, the module that declares it, and its name there.

    The remarks are what its documentation says after the README, in Markdown.
    """

    component: Component
    module: str
    attribute: str = "COMPONENT"
    remarks: str = ""

    @property
    def home(self) -> str:
        """Package that the component lives in, as `warmlink.controllers`."""
        return self.module.rpartition(".")[0].rpartition(".")[0]

    @property
    def readme(self) -> Path:
        """README.md beside the declaration; NAME.md in the current folder for a script or a notebook."""
        if self.module == "__main__":
            return Path(f"{self.component.name}.md")
        return Path(str(importlib.import_module(self.module).__file__)).with_name("README.md")


def catalogue() -> tuple[Entry, ...]:
    """Every component, in the order of names, plant before controllers."""
    entries = []
    for home in HOMES:
        package = importlib.import_module(home)
        for found in sorted(pkgutil.iter_modules(package.__path__), key=lambda found: found.name):
            module = f"{home}.{found.name}.component"
            if found.ispkg and importlib.util.find_spec(module) is not None:
                declared = getattr(importlib.import_module(module), "COMPONENT", None)
                if isinstance(declared, Component):
                    entries.append(Entry(declared, module))
    return tuple(entries)

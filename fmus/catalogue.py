"""The components that exist: every folder with a file `component.py` is one, and what other packages add."""

import hashlib
import importlib
import importlib.util
import pkgutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from warmlink.fmus.component import Component
from warmlink.fmus.plugins import KINDS, Plugin, plugins


@dataclass(frozen=True)
class Entry:
    """A component, the module that declares it, and its name there.

    `law` is what a law is called, as `lag`, empty for others; `added` says which package it is from, if not
    from warmlink. The remarks are what its documentation says after the README, in Markdown.
    """

    component: Component
    module: str
    attribute: str = "COMPONENT"
    remarks: str = ""
    law: str = ""
    added: Plugin | None = None

    @property
    def readme(self) -> Path:
        """README.md beside the declaration; NAME.md in the current folder for a script or a notebook."""
        if self.module == "__main__":
            return Path(f"{self.component.name}.md")
        return Path(str(importlib.import_module(self.module).__file__)).with_name("README.md")

    @property
    def digest(self) -> str:
        """Digest of the files beside the declaration, from which the FMU of an added component is built."""
        held = sorted(each for each in self.readme.parent.rglob("*") if each.suffix in (".py", ".md"))
        return hashlib.sha256(b"".join(each.read_bytes() for each in held)).hexdigest()[:16]


def catalogue() -> tuple[Entry, ...]:
    """Every component, in the order of names, plant before controllers, what other packages add at the end.

    Raises InputError if what a package adds is none, or has the name of another component.
    """
    found = [*_in_folders_of("warmlink.fmus", ""), *_in_folders_of("warmlink.controllers", "{}"), *_added()]
    names = [entry.component.name for entry in found]
    for entry in found:
        if entry.added and names.count(entry.component.name) > 1:
            raise entry.added.refused(f"another component is called {entry.component.name}")
    return tuple(found)


def _in_folders_of(home: str, law: str) -> Iterator[Entry]:
    package = importlib.import_module(home)
    for found in sorted(pkgutil.iter_modules(package.__path__), key=lambda found: found.name):
        module = f"{home}.{found.name}.component"
        if found.ispkg and importlib.util.find_spec(module) is not None:
            declared = getattr(importlib.import_module(module), "COMPONENT", None)
            if isinstance(declared, Component):
                yield Entry(declared, module, law=law.format(found.name))


def _added() -> Iterator[Entry]:
    for each in (*plugins("components"), *plugins("laws")):
        declared, law = each.load(), each.name if each.kind == "laws" else ""
        if not isinstance(declared, Component):
            raise each.refused(f"is not {KINDS[each.kind]}")
        yield Entry(declared, each.module, each.attribute, law=law, added=each)

"""Components and controllers by the names that people give them."""

from __future__ import annotations

import zipfile
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.fmus.catalogue import Entry, catalogue
from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.records import dataclass
from warmlink.fmus.reduced_link.component import reduced_link
from warmlink.fmus.reduced_link.equations import STORED, read_stored

if TYPE_CHECKING:
    from warmlink.orchestration.fmu_store import FmuStore


@dataclass(frozen=True)
class Controller:
    """A controller that warmlink ships: what people call it, and its component.

    `digest` is of the file that it was written in; empty for a shipped one.
    """

    name: str
    component: Component
    digest: str = ""

    @property
    def kinds(self) -> set[str]:
        """Names of warmlink's components that it needs."""
        return {self.component.name}

    def files(self, store: FmuStore) -> dict[str, Path]:
        """Files of FMUs that it brings along, by the component's name."""
        return {}


@cache
def entries() -> dict[str, Entry]:
    """Every component with the place of its declaration, by its own name, as `ThermalLink`."""
    return {entry.component.name: entry for entry in catalogue()}


def components() -> dict[str, Component]:
    """Every component by its own name."""
    return {name: entry.component for name, entry in entries().items()}


def reduced_link_in(fmu: Path) -> Component | None:
    """Declaration of the reduced link that an FMU is, from the model that it holds; None for another FMU."""
    try:
        with zipfile.ZipFile(fmu) as archive:
            return reduced_link(fmu.stem, read_stored(archive.read(STORED)))
    except (OSError, KeyError, ValueError, TypeError, zipfile.BadZipFile):
        return None


@cache
def controllers() -> dict[str, Component]:
    """Compensating controllers by the name of their folder, as `lag`."""
    own = [entry for entry in entries().values() if entry.home == "warmlink.controllers"]
    return {entry.module.split(".")[-2]: entry.component for entry in own}


def controller(name: str) -> Component:
    """Controller by its name; InputError if there is none of that name."""
    if name not in controllers():
        raise InputError(f"{name}: no such controller; {instead(name, controllers())}")
    return controllers()[name]


def shipped(name: str) -> Controller:
    """Controller with its name; raises as `controller`."""
    return Controller(name, controller(name))

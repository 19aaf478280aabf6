"""Components and controllers by the names that people give them."""

from __future__ import annotations

from functools import cache

from warmlink.fmus.catalogue import Entry, catalogue
from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead

CONTROLLERS = "warmlink.controllers"


@cache
def entries() -> dict[str, Entry]:
    """Every component with the place of its declaration, by its own name, as `ThermalLink`."""
    return {entry.component.name: entry for entry in catalogue()}


def components() -> dict[str, Component]:
    """Every component by its own name."""
    return {name: entry.component for name, entry in entries().items()}


@cache
def controllers() -> dict[str, Component]:
    """Compensating controllers by the name of their folder, as `lag`."""
    return {
        entry.module.split(".")[-2]: entry.component
        for entry in entries().values()
        if entry.home == CONTROLLERS
    }


def controller(name: str) -> Component:
    """Controller by its name.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    if name not in controllers():
        raise InputError(f"{name}: no such controller; {instead(name, controllers())}")
    return controllers()[name]

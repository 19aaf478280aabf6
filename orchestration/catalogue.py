"""The components and controllers that there are: every folder that declares one, with no list to keep."""

from __future__ import annotations

import importlib
import importlib.util
import pkgutil
from functools import cache
from types import ModuleType

import warmlink.controllers
import warmlink.fmus
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.component import Component


@cache
def plants() -> dict[str, Component]:
    """Plant and instrument components by folder, as `thermal_link`."""
    return _declared(warmlink.fmus)


@cache
def controllers() -> dict[str, Component]:
    """Compensating controllers by folder, which is the controller's name on the command line."""
    return _declared(warmlink.controllers)


def components() -> dict[str, Component]:
    """All components by their own name, as `ThermalLink`."""
    return {each.name: each for each in (*plants().values(), *controllers().values())}


def controller(name: str) -> Component:
    """Controller by its name.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    if name not in controllers():
        raise InputError(f"{name}: no such controller; choose {', '.join(controllers())}")
    return controllers()[name]


def _declared(package: ModuleType) -> dict[str, Component]:
    found = {}
    for entry in pkgutil.iter_modules(package.__path__):
        if not entry.ispkg:
            continue
        module = f"{package.__name__}.{entry.name}.component"
        if importlib.util.find_spec(module) is not None:
            declared = getattr(importlib.import_module(module), "COMPONENT", None)
            if declared is not None:
                found[entry.name] = declared
    return found

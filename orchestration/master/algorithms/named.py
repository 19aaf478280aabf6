"""Master algorithms by name: the `MASTERS` of each file in this folder, and what other packages add."""

from __future__ import annotations

import pkgutil
from functools import cache
from importlib import import_module

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.plugins import KINDS, plugins
from warmlink.orchestration.master import algorithms
from warmlink.orchestration.master.algorithms.algorithm import Algorithm


@cache
def _masters() -> dict[str, tuple[Algorithm, str]]:
    found: dict[str, tuple[Algorithm, str]] = {}
    for each in pkgutil.iter_modules(algorithms.__path__, f"{algorithms.__name__}."):
        if each.name != __name__:
            found |= getattr(import_module(each.name), "MASTERS", {})
    for added in plugins("masters"):
        made = added.load()
        if not isinstance(made, Algorithm) or added.name in found:
            told = "another one has this name" if added.name in found else f"is not {KINDS['masters']}"
            raise added.refused(told)
        found[added.name] = made, (type(made).__doc__ or "").partition("\n")[0]
    return found


def masters() -> dict[str, Algorithm]:
    """Every algorithm by its name, with its default settings."""
    return {name: made for name, (made, _) in _masters().items()}


def algorithm(name: str) -> Algorithm:
    """Give an algorithm by its name, with its default settings; InputError if there is none."""
    if name not in _masters():
        raise InputError(f"master: {name!r} is not known; {instead(name, _masters())}")
    return _masters()[name][0]


def about(name: str) -> str:
    """Say in a line what an algorithm does."""
    return _masters()[name][1]

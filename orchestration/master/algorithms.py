"""The master algorithms by name: the one place where a name becomes an algorithm."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithm import Algorithm
from warmlink.orchestration.master.gauss_seidel import GaussSeidel
from warmlink.orchestration.master.jacobi import Jacobi

_MAKERS: Mapping[str, Callable[[], Algorithm]] = {"jacobi": Jacobi, "gauss_seidel": GaussSeidel}

ALGORITHMS: Mapping[str, str] = MappingProxyType(
    {name: (maker.__doc__ or "").partition("\n")[0].rstrip(".") for name, maker in _MAKERS.items()}
)
"""What each algorithm does, by its name."""


def algorithm_named(name: str) -> Algorithm:
    """Algorithm with its default settings.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    if name not in _MAKERS:
        raise InputError(f"{name}: no such master algorithm; choose {', '.join(_MAKERS)}")
    return _MAKERS[name]()

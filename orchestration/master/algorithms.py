"""All master algorithms by name: the one place that a new one is entered in."""

from __future__ import annotations

from collections.abc import Callable

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithm import Algorithm
from warmlink.orchestration.master.fixed_point import FixedPoint
from warmlink.orchestration.master.gauss_seidel import GaussSeidel
from warmlink.orchestration.master.interface_newton import InterfaceNewton
from warmlink.orchestration.master.jacobi import Jacobi

ALGORITHMS: dict[str, Callable[[], Algorithm]] = {
    "jacobi": Jacobi,
    "jacobi_linear": lambda: Jacobi(extrapolation=1),
    "jacobi_quadratic": lambda: Jacobi(extrapolation=2),
    "gauss_seidel": GaussSeidel,
    "fixed_point": FixedPoint,
    "interface_newton": InterfaceNewton,
}


def algorithm(name: str) -> Algorithm:
    """Give an algorithm by its name, with its default settings.

    Raises
    ------
    InputError
        Where there is none of that name.
    """
    if name not in ALGORITHMS:
        raise InputError(f"master: {name!r} is not known; choose one of {', '.join(ALGORITHMS)}")
    return ALGORITHMS[name]()


def about(name: str) -> str:
    """Say in a line what an algorithm does."""
    return (type(algorithm(name)).__doc__ or "").partition("\n")[0].rstrip(".")

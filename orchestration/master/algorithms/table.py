"""All master algorithms by name: the one place that a new one is entered in."""

from __future__ import annotations

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.doubling import StepDoubling
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel, Jacobi
from warmlink.orchestration.master.algorithms.iterated import FixedPoint, InterfaceNewton

FOLLOWING = "error_controlled"
"""Name of the algorithm whose steps follow the error."""

_ENTRIES: dict[str, tuple[Algorithm, str]] = {
    "jacobi": (Jacobi(), "all slaves step at once with held inputs, as libcosim and Ecos do it"),
    "jacobi_settled": (
        Jacobi(settled=True),
        "Jacobi whose outputs with direct feedthrough are read again after the exchange",
    ),
    "gauss_seidel": (GaussSeidel(), "slaves step one after the other, each with the newest values"),
    "fixed_point": (
        FixedPoint(),
        "steps are repeated until inputs and outputs agree, after Anderson, inputs interpolated",
    ),
    "interface_newton": (
        InterfaceNewton(),
        "the same by Newton's method, with step Jacobians from rollback differences",
    ),
    FOLLOWING: (
        StepDoubling(InterfaceNewton()),
        "interface Newton in parts of a step, as small as an estimate of the coupling error asks",
    ),
}

ALGORITHMS = {name: made for name, (made, _) in _ENTRIES.items()}


def algorithm(name: str) -> Algorithm:
    """Give an algorithm by its name, with its default settings; InputError where there is none."""
    if name not in ALGORITHMS:
        raise InputError(f"master: {name!r} is not known; {instead(name, ALGORITHMS)}")
    return ALGORITHMS[name]


def about(name: str) -> str:
    """Say in a line what an algorithm does."""
    return _ENTRIES[name][1]

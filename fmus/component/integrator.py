"""The linearly implicit integrator inside the Python FMUs, and the Jacobian it uses.

ROS2 of J. G. Verwer, E. J. Spee, J. G. Blom and W. Hundsdorfer, "A second-order Rosenbrock method applied
to photochemical dispersion problems", SIAM J. Sci. Comput. 20 (1999) 1456-1480: two stages, one matrix,
L-stable for gamma = 1 - 1/sqrt(2), and of order 2 whatever matrix stands in for the Jacobian, so that
inputs may vary within a step.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

GAMMA = 1 - 1 / math.sqrt(2)

COMPLEX_STEP = 1e-30
"""Imaginary step; without subtraction there is no cancellation, so it may be this small."""


def rosenbrock_step(
    rates: Callable[[Vector, float], Vector], jacobian: Matrix, x: Vector, time: float, step: float
) -> Vector:
    """State after one step.

    Parameters
    ----------
    rates : function of state and time in s that gives the state's time derivative, shape (n,)
    jacobian : derivative of the rates by the state, shape (n, n), in 1/s
    x : state, shape (n,)
    time, step : start of the step and its length in s

    Returns
    -------
    numpy.ndarray
        State at `time + step`, shape (n,).
    """
    inverse = np.linalg.inv(np.eye(x.size) - GAMMA * step * jacobian)
    first = inverse @ rates(x, time)
    second = inverse @ (rates(x + step * first, time + step) - 2 * first)
    return x + step * (1.5 * first + 0.5 * second)


class ComplexStepJacobian:
    """Jacobian by complex step, with as few evaluations as its structure allows.

    Columns that share no row are stepped together (Curtis, Powell and Reid 1974), so that a chain of
    cells takes three evaluations whatever its length.

    Parameters
    ----------
    structure : where the Jacobian may differ from zero, shape (n, n), boolean
    """

    def __init__(self, structure: NDArray[np.bool_]) -> None:
        self._structure = structure
        self._groups = _independent_columns(structure)

    def __call__(
        self, rates: Callable[[NDArray[np.complex128]], NDArray[np.complex128]], x: Vector
    ) -> Matrix:
        """Jacobian of `rates` at `x`, shape (n, n)."""
        jacobian = np.zeros(self._structure.shape)
        for columns in self._groups:
            stepped = x.astype(np.complex128)
            stepped[columns] += 1j * COMPLEX_STEP
            slope = np.imag(rates(stepped)) / COMPLEX_STEP
            for column in columns:
                rows = self._structure[:, column]
                jacobian[rows, column] = slope[rows]
        return jacobian


def _independent_columns(structure: NDArray[np.bool_]) -> list[list[int]]:
    groups: list[tuple[NDArray[np.bool_], list[int]]] = []
    for column in range(structure.shape[1]):
        rows = structure[:, column]
        for taken, members in groups:
            if not np.any(taken & rows):
                taken |= rows
                members.append(column)
                break
        else:
            groups.append((rows.copy(), [column]))
    return [members for _, members in groups]

"""The linearly implicit integrator inside the FMUs and the diagnosis, and the Jacobian it uses.

ROS2 of J. G. Verwer, E. J. Spee, J. G. Blom and W. Hundsdorfer, "A second-order Rosenbrock method applied
to photochemical dispersion problems", SIAM J. Sci. Comput. 20 (1999) 1456-1480: two stages, one matrix,
L-stable for gamma = 1 - 1/sqrt(2), and of order 2 whatever matrix stands in for the Jacobian, so that
inputs may vary within a step.

The step stands here once: Python FMUs take it as it is, and the C of native FMUs and of joined runs is
generated from it. `python -m benchmarks.cores` times what is written in C besides.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

GAMMA = 1 - 1 / math.sqrt(2)

COMPLEX_STEP = 1e-30
"""Imaginary step; without subtraction there is no cancellation, so it may be this small."""


def ros2(
    slope: Any, solve: Callable[[Any], Any], slope_ahead: Callable[[Any], Any], x: Any, step: Any
) -> Any:
    """State after one step of ROS2: arrays, or expressions of CasADi.

    Parameters
    ----------
    slope : time derivative of the state at the start of the step, of the shape of `x`
    solve : solution y of (I - gamma step J) y = b for a given b, with J the Jacobian
    slope_ahead : time derivative at the end of the step of a given state
    x : state, beside it the columns of its sensitivities where there are any
    step : length of the step in s
    """
    first = solve(slope)
    second = solve(slope_ahead(x + step * first) - 2 * first)
    return x + step * (1.5 * first + 0.5 * second)


def solution_of(jacobian: Matrix, step: float) -> Callable[[Vector], Vector]:
    """Solution y of (I - gamma step J) y = b as a function of b, for a Jacobian in 1/s, shape (n, n)."""
    return np.linalg.inv(np.eye(len(jacobian)) - GAMMA * step * jacobian).__matmul__


class ComplexStepJacobian:
    """Jacobian by complex step, with as few evaluations as its structure allows.

    The structure, shape (n, n), tells where it may differ from zero. Columns that share no row are stepped
    together (Curtis, Powell and Reid 1974), so that a chain of cells takes three evaluations of any length.
    """

    def __init__(self, structure: NDArray[np.bool_]) -> None:
        self._structure = structure
        self._groups: list[list[int]] = []
        for column, rows in enumerate(structure.T):
            fits = (each for each in self._groups if not np.any(structure[:, each].any(axis=1) & rows))
            group = next(fits, [])
            if not group:
                self._groups.append(group)
            group.append(column)

    def __call__(
        self, rates: Callable[[NDArray[np.complex128]], NDArray[np.complex128]], x: Vector
    ) -> Matrix:
        """Jacobian of `rates` at `x`, shape (n, n)."""
        jacobian = np.zeros(self._structure.shape)
        for columns in self._groups:
            stepped = x.astype(np.complex128)
            stepped[columns] += 1j * COMPLEX_STEP
            slope = np.imag(rates(stepped)) / COMPLEX_STEP
            jacobian[:, columns] = np.where(self._structure[:, columns], slope[:, None], 0.0)
        return jacobian

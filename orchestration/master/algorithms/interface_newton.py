"""Newton iteration of a macro step on its interface, with step Jacobians from rollback differences.

Directional derivatives hold a slave's state fixed, so through a thermal link they are zero; what counts
is how the outputs at the end of a step answer to the inputs during it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Stepper
from warmlink.orchestration.master.algorithms.iteration import IteratedStepper, Sweep, Vector
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.network import Network

DIFFERENCE = 1e-6  # of the nominal value


@dataclass(frozen=True)
class InterfaceNewton(Algorithm):
    """Solve each step's interface equations by Newton's method, reusing the Jacobian while it serves.

    Parameters
    ----------
    interpolation : int
        Order 0, 1 or 2 of the inputs during a step.
    tolerance : float
        On the residual of each iterated input, as a fraction of its nominal value.
    most : int
        Newton iterations after which a step has not converged.
    """

    interpolation: int = 1
    tolerance: float = 1e-10
    most: int = 20

    @property
    def order(self) -> int:
        """Order of convergence of the coupling error."""
        return 1 + self.interpolation

    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network."""
        return IteratedStepper(network, self.interpolation, lambda: Newton(self.tolerance, self.most))


class Newton:
    """Newton's method for one group, its Jacobian kept from step to step."""

    def __init__(self, tolerance: float, most: int) -> None:
        self.tolerance = tolerance
        self.most = most
        self._jacobian: Vector | None = None

    def solve(self, sweep: Sweep, guess: Vector, scale: Vector) -> Vector | None:
        """Iterate to the tolerance; a Jacobian that reduces the residual too slowly is made anew."""
        x, kept, last = guess, self._jacobian is not None, np.inf
        for _ in range(self.most):
            residual = sweep(x) - x
            if not np.all(np.isfinite(residual)):
                return None
            size = np.maximum(scale, np.abs(x))
            error = float(np.max(np.abs(residual) / size))
            if error <= self.tolerance:
                return x
            if self._jacobian is None or error > 0.1 * last or not kept:
                self._jacobian, kept = self._differences(sweep, x, residual, size), True
            last = error
            x = x - np.linalg.solve(self._jacobian, residual)
        return None

    def memory(self) -> object:
        """Give the Jacobian."""
        return self._jacobian

    def recall(self, memory: object) -> None:
        """Take a Jacobian."""
        self._jacobian = None if memory is None else np.array(memory, float)

    @staticmethod
    def _differences(sweep: Sweep, x: Vector, residual: Vector, size: Vector) -> Vector:
        columns = []
        for j in range(len(x)):
            moved = x.copy()
            moved[j] += DIFFERENCE * size[j]
            columns.append((sweep(moved) - moved - residual) / (moved[j] - x[j]))
        return np.array(columns).T

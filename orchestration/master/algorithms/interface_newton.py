"""Newton iteration of a macro step on its interface, with step Jacobians from rollback differences.

Directional derivatives hold a slave's state fixed, so through a thermal link they are zero; what counts
is how the outputs at the end of a step answer to the inputs during it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warmlink.orchestration.master.algorithms.iteration import Iterated, Sweep, Vector

DIFFERENCE = 1e-6  # of the nominal value


@dataclass(frozen=True)
class InterfaceNewton(Iterated):
    """Solve each step's interface equations by Newton's method, reusing the Jacobian while it serves."""

    most: int = 20

    def solve(
        self, sweep: Sweep, guess: Vector, scale: Vector, kept: Vector | None
    ) -> tuple[bool, Vector | None]:
        """Iterate to the tolerance; a Jacobian that reduces the residual too slowly is made anew."""
        x, jacobian, last = guess, kept, np.inf
        for _ in range(self.most):
            residual = sweep(x) - x
            if not np.all(np.isfinite(residual)):
                return False, jacobian
            size = np.maximum(scale, np.abs(x))
            error = float(np.max(np.abs(residual) / size))
            if error <= self.tolerance:
                return True, jacobian
            if jacobian is None or error > 0.1 * last:
                jacobian = _differences(sweep, x, residual, size)
            last = error
            x = x - np.linalg.solve(jacobian, residual)
        return False, jacobian


def _differences(sweep: Sweep, x: Vector, residual: Vector, size: Vector) -> Vector:
    columns = []
    for j in range(len(x)):
        moved = x.copy()
        moved[j] += DIFFERENCE * size[j]
        columns.append((sweep(moved) - moved - residual) / (moved[j] - x[j]))
    return np.array(columns).T

"""Fixed-point iteration of a macro step, accelerated after Anderson."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warmlink.orchestration.master.algorithms.iteration import Iterated, Sweep, Vector


@dataclass(frozen=True)
class FixedPoint(Iterated):
    """Repeat each step with the inputs that the last repetition answered, mixed after Anderson.

    D. G. Anderson, J. ACM 12 (1965) 547; the mixing of H. F. Walker and P. Ni, SIAM J. Numer. Anal. 49
    (2011) 1715.

    Parameters
    ----------
    interpolation, tolerance, most
        As `Iterated`.
    depth : int
        How many earlier repetitions are mixed; 0 is the plain fixed-point iteration.
    """

    depth: int = 5

    def solve(self, sweep: Sweep, guess: Vector, scale: Vector, kept: Vector | None) -> tuple[bool, None]:
        """Iterate to the tolerance; nothing is carried from step to step."""
        x = guess
        steps: list[Vector] = []
        changes: list[Vector] = []
        previous: tuple[Vector, Vector] | None = None
        for _ in range(self.most):
            residual = sweep(x) - x
            if not np.all(np.isfinite(residual)):
                return False, None
            size = np.maximum(scale, np.abs(x))
            if np.all(np.abs(residual) <= self.tolerance * size):
                return True, None
            if previous is not None and self.depth:
                steps = [*steps, x - previous[0]][-self.depth :]
                changes = [*changes, residual - previous[1]][-self.depth :]
            previous = (x, residual)
            x = x + residual
            if changes:
                F, X = np.array(changes).T, np.array(steps).T
                mix = np.linalg.lstsq(F / size[:, None], residual / size, rcond=1e-12)[0]
                x = x - (X + F) @ mix
        return False, None

"""Fixed-point iteration of a macro step, accelerated after Anderson."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Stepper
from warmlink.orchestration.master.algorithms.iteration import IteratedStepper, Sweep, Vector
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.network import Network


@dataclass(frozen=True)
class FixedPoint(Algorithm):
    """Repeat each step with the inputs that the last repetition answered, mixed after Anderson.

    D. G. Anderson, J. ACM 12 (1965) 547; the mixing of H. F. Walker and P. Ni, SIAM J. Numer. Anal. 49
    (2011) 1715.

    Parameters
    ----------
    interpolation : int
        Order 0, 1 or 2 of the inputs during a step.
    depth : int
        How many earlier repetitions are mixed; 0 is the plain fixed-point iteration.
    tolerance : float
        On the change of each iterated input, as a fraction of its nominal value.
    most : int
        Repetitions after which a step has not converged.
    """

    interpolation: int = 1
    depth: int = 5
    tolerance: float = 1e-10
    most: int = 50

    @property
    def order(self) -> int:
        """Order of convergence of the coupling error."""
        return 1 + self.interpolation

    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network."""
        return IteratedStepper(
            network, self.interpolation, lambda: Anderson(self.depth, self.tolerance, self.most)
        )


class Anderson:
    """Anderson acceleration of one group's fixed-point iteration."""

    def __init__(self, depth: int, tolerance: float, most: int) -> None:
        self.depth = depth
        self.tolerance = tolerance
        self.most = most

    def solve(self, sweep: Sweep, guess: Vector, scale: Vector) -> Vector | None:
        """Iterate to the tolerance."""
        x = guess
        steps: list[Vector] = []
        changes: list[Vector] = []
        previous: tuple[Vector, Vector] | None = None
        for _ in range(self.most):
            answer = sweep(x)
            residual = answer - x
            if not np.all(np.isfinite(residual)):
                return None
            size = np.maximum(scale, np.abs(x))
            if np.all(np.abs(residual) <= self.tolerance * size):
                return x
            if previous is not None and self.depth:
                steps = [*steps, x - previous[0]][-self.depth :]
                changes = [*changes, residual - previous[1]][-self.depth :]
            previous = (x, residual)
            x = x + residual
            if changes:
                F, X = np.array(changes).T, np.array(steps).T
                mix = np.linalg.lstsq(F / size[:, None], residual / size, rcond=1e-12)[0]
                x = x - (X + F) @ mix
        return None

    def memory(self) -> object:
        """Nothing is carried from step to step."""
        return None

    def recall(self, memory: object) -> None:
        """Nothing is carried from step to step."""

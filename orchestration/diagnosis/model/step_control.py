"""Steps whose error is known: each is compared with two shorter ones on the inputs as they were logged.

Along the run with nothing freed. A step that errs is cut in two, and cut again; inputs that change within a
step are replaced by their mean only where that changes nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from warmlink.fmus.component.integrator import GAMMA, ros2
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.model.equations import Linearised
from warmlink.orchestration.diagnosis.model.grid import Levels, Resolution, Shares, Steps, layout

_CUTS = 5
"""How often a step may be cut in two."""

_ORDINARY = 300.0
"""K; the tolerance of a larger state, such as a heat in J, grows in proportion to it."""

_MEMORY = 600.0
"""s over which the error of a mean adds up, for it leans to one side in step after step."""


def controlled(rates: Linearised, levels: Levels, x: Array, resolution: Resolution) -> Steps:
    """Steps over a run that meet their tolerance wherever cutting them reaches it.

    Parameters
    ----------
    rates : of the run, its parameters set
    levels : the run's inputs
    x : states at the start, shape (n,)
    resolution : first steps and tolerance
    """
    control = _Control(rates, levels, resolution.tolerance)
    for start, end in pairwise(layout(levels, resolution).tolist()):
        x = control.settle(control.step(x, start, end), _CUTS)
    return control.steps()


Weights = tuple[Array, Array, Array, Array]


def hermite(s: Array, length: Array) -> Weights:
    """Weights of a cubic in time at the share `s` of a step's length in s.

    They are those of the first value, the last one, the first slope and the last one.
    """
    outside, inside = (1 + 2 * s) * (1 - s) ** 2, s**2 * (3 - 2 * s)
    return outside, inside, length * s * (1 - s) ** 2, -length * s**2 * (1 - s)


def inverse_of_step(scaled: Array) -> Array:
    """Inverse of the method's matrix, of the Jacobian times the step and the method's gamma, shape (n, n)."""
    from scipy.linalg.lapack import dgetrf, dgetri  # half the time of `numpy.linalg.inv` at twenty states

    factors, pivots, _ = dgetrf(np.eye(len(scaled)) - scaled, overwrite_a=True)
    return np.asarray(dgetri(factors, pivots, overwrite_lu=True)[0])


@dataclass(frozen=True)
class _Step:
    """One step: times in s, states and their slopes at both ends, and the inverse matrix of the method."""

    start: float
    end: float
    x: Array
    reached: Array
    first: Array
    last: Array
    inverse: Array

    @property
    def bend(self) -> Array:
        """Difference from the trapezoidal rule: about the error of the step, at no cost."""
        return self.settled(self.reached - self.x - (self.end - self.start) / 2 * (self.first + self.last))

    def settled(self, error: Array) -> Array:
        """An error without what settles within the step, where slopes are rounding and say nothing.

        E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, Springer 1996, eq. (IV.8.20).
        """
        return np.asarray(self.inverse @ error)

    def at(self, time: float) -> Array:
        """States within the step, interpolated as for the rows of a run."""
        length = np.array(self.end - self.start)
        known = np.stack([self.x, self.reached, self.first, self.last])
        return np.stack(hermite((time - self.start) / length, length)) @ known


class _Control:
    def __init__(self, rates: Linearised, levels: Levels, tolerance: float) -> None:
        self._rates, self._levels, self._tolerance = rates, levels, tolerance
        self._time = [0.0]
        self._means: list[Array] = []
        self._shares: list[Shares] = []

    def steps(self) -> Steps:
        """All steps that were settled."""
        inputs = np.vstack([self._levels.values.T, *self._means])
        return Steps(np.array(self._time), inputs, tuple(self._shares))

    def settle(self, step: _Step, cuts: int) -> Array:
        """Add a step, or several shorter ones in its place; gives the states at its end."""
        x, start, end = step.x, step.start, step.end
        shares = self._levels.within(start, end)
        if cuts > 0 and (len(shares) > 1 or not self._small(step.bend, x)):
            cut = self._levels.cut(start, end)
            half = self.step(x, start, cut)
            there = self.step(half.reached, cut, end).reached
            between = step.settled(step.at(cut) - half.reached)
            wrong = np.maximum(np.abs(step.reached - there), np.abs(between))
            if not self._small(wrong, x):
                return self.settle(self.step(self.settle(half, cuts - 1), cut, end), cuts - 1)
        mean = self._levels.mean(shares) if len(shares) > 1 else None
        if mean is not None:
            leaning = self.step(x, start, end, mean).reached - step.reached
            if self._small(leaning * _MEMORY / (end - start), x):
                shares = ((self._levels.values.shape[1] + len(self._means), 1.0),)
                self._means.append(mean)
        self._time.append(end)
        self._shares.append(shares)
        return step.reached

    def _small(self, error: Array, x: Array) -> bool:
        return bool(np.all(np.abs(error) <= self._tolerance * np.maximum(1.0, np.abs(x) / _ORDINARY)))

    def step(self, x: Array, start: float, end: float, mean: Array | None = None) -> _Step:
        """A step on the inputs as they were logged, or on their mean."""
        if mean is None:
            acting = [(self._levels.values[:, i], share) for i, share in self._levels.within(start, end)]
        else:
            acting = [(mean, 1.0)]
        step = end - start
        first, jacobian, _ = self._rates.averaged(x, start, acting)
        inverse = inverse_of_step((GAMMA * step) * jacobian)

        def slope_ahead(ahead: Array) -> Array:
            return self._rates.averaged(ahead, end, acting)[0]

        reached = ros2(first, inverse.__matmul__, slope_ahead, x, step)
        return _Step(start, end, x, reached, first, slope_ahead(reached), inverse)

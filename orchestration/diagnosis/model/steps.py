"""Time steps of a run: short after its inputs change, growing while they stay, and their error is known.

Along the run with nothing freed each step is compared with two shorter ones on the inputs as they were
logged. A step that errs is cut in two, and cut again; inputs that change within a step are replaced by their
mean only where that changes nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.model.integrator import Integrator, Shares, Steps

SIGNIFICANT = 0.1
"""Share of an input's range by which it must change for the steps to begin anew."""

MOST_EVENTS = 150
"""An input that changes more often is noisy: steps then average over it."""

MOST_LEVELS = 20_000


_CUTS = 5
"""How often a step may be cut in two."""

_AHEAD = 32
"""Steps that are taken at once, where nothing changes."""

_ORDINARY = 300.0
"""K; the tolerance of a larger state, such as a heat in J, grows in proportion to it."""

_MEMORY = 600.0
"""s over which the error of a mean adds up, for it leans to one side in step after step."""


@dataclass(frozen=True)
class Resolution:
    """How finely to integrate.

    Attributes
    ----------
    cells : of the link
    first, longest : steps in s after a change of the inputs, and at most
    growth : of the steps, in s for each s since the change
    tolerance : K, error of one step beyond which it is cut in two
    """

    cells: int
    first: float
    growth: float
    longest: float
    tolerance: float


SEARCH = Resolution(20, 3.0, 0.2, 60.0, 0.03)
"""For comparing models: its error is made up for by one run at `FINAL` resolution."""

FINAL = Resolution(40, 1.0, 0.08, 20.0, 0.0003)

CHECK_CELLS = 80
"""With half of each `FINAL` step and every input as it was logged, to see whether `FINAL` is fine enough."""


class Levels:
    """What the inputs are from row to row.

    Parameters
    ----------
    time : rows in s, rising from 0, shape (rows,)
    inputs : held from each row to the next, shape (inputs, rows)
    discrete : inputs whose values are names, not amounts: 0 off, 2 held; shape (inputs,)

    Attributes
    ----------
    starts : s at which a level begins, shape (levels,)
    table : shape (levels, inputs)
    end : s at which the last one ends
    """

    def __init__(self, time: Array, inputs: Array, discrete: NDArray[np.bool_]) -> None:
        rows = _changes(inputs, discrete)
        self.starts, self.end = time[rows], float(time[-1])
        self.table = np.ascontiguousarray(inputs[:, rows].T)
        self._discrete = discrete

    def within(self, start: float, end: float) -> Shares:
        """Levels that act from one time in s to another, in order, with their shares of it."""
        first = int(np.searchsorted(self.starts, start, side="right")) - 1
        last = int(np.searchsorted(self.starts, end, side="left"))
        if last - first == 1:
            return ((first, 1.0),)
        edges = np.concatenate([[start], self.starts[first + 1 : last], [end]])
        shares = np.diff(edges) / (end - start)
        return tuple(zip(range(first, last), shares.tolist(), strict=True))

    def mean(self, shares: Shares) -> Array | None:
        """One level in place of several; None where they differ in an input that has no mean."""
        columns, weights = zip(*shares, strict=True)
        values = self.table[list(columns)]
        if np.any(values[:, self._discrete] != values[0, self._discrete]):
            return None
        return np.where(self._discrete, values[0], np.array(weights) @ values)

    def cut(self, start: float, end: float) -> float:
        """Time in s at which to cut a step in two: the change of level nearest its middle, or that itself."""
        inside = self.starts[np.searchsorted(self.starts, start, "right") : np.searchsorted(self.starts, end)]
        middle = (start + end) / 2
        return float(inside[np.argmin(np.abs(inside - middle))]) if inside.size else middle

    def events(self) -> Array:
        """Times in s at which an input that is not noisy changes by much, shape (events,)."""
        return self.starts[1:][_large(self.table.T)]

    def steps(self, points: Array) -> Steps:
        """Steps between points in s, and every level as it is."""
        return Steps(points, self.table, tuple(self.within(a, b) for a, b in pairwise(points.tolist())))

    def halved(self, points: Array) -> Steps:
        """Two steps for each between points in s, and every level as it is."""
        return self.steps(np.insert(points, np.arange(1, points.size), (points[:-1] + points[1:]) / 2))


def layout(levels: Levels, resolution: Resolution) -> Array:
    """Points in s between steps that begin anew with each event, shape (steps + 1,)."""
    points = [0.0]
    events = levels.events()
    for start, end in zip([0.0, *events], [*events, levels.end], strict=True):
        while end - points[-1] > 1e-9:
            left = end - points[-1]
            limit = min(resolution.longest, resolution.first + resolution.growth * (points[-1] - start))
            points.append(points[-1] + left / np.ceil(left / limit) if left > limit else end)
    return np.array(points)


def _large(levels: Array) -> NDArray[np.bool_]:
    """Whether the next level brings an event, shape (levels - 1,)."""
    span = np.ptp(levels, axis=1, keepdims=True)
    large = np.abs(np.diff(levels, axis=1)) > SIGNIFICANT * span
    large[large.sum(axis=1) > MOST_EVENTS] = False
    return np.asarray(large.any(axis=0))


def _changes(inputs: Array, discrete: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Rows at which any input changes; thinned where there are too many to step through.

    An event, or another value of a discrete input, is kept with the row that it came in.
    """
    changed = np.any(np.diff(inputs, axis=1) != 0, axis=0)
    changed[-1:] = False  # what the last row brings acts on nothing
    rows = np.concatenate([[0], np.flatnonzero(changed) + 1])
    if rows.size <= MOST_LEVELS:
        return rows
    levels = inputs[:, rows]
    kept = np.arange(rows.size) % -(-rows.size // MOST_LEVELS) == 0
    kept[1:] |= _large(levels) | np.any(np.diff(levels[discrete], axis=1) != 0, axis=0)
    return rows[kept]


def controlled(integrator: Integrator, levels: Levels, x: Array, resolution: Resolution) -> Steps:
    """Steps over a run that meet their tolerance wherever cutting them reaches it.

    Parameters
    ----------
    integrator : of the run, with nothing freed
    levels : the run's inputs
    x : states at the start, shape (n,)
    resolution : first steps and tolerance
    """
    control = _Control(integrator, levels, resolution.tolerance)
    points = layout(levels, resolution)
    ahead = 1
    while points.size > 1:
        passed, x = control.run(x, points[: ahead + 1])
        ahead = min(2 * ahead, _AHEAD) if passed == ahead else 1
        points = points[passed:]
        if ahead == 1 and points.size > 1:
            x = control.settle(control.step(x, *points[:2].tolist()), _CUTS)
            points = points[1:]
    inputs = np.vstack([levels.table, *control.means])
    return Steps(np.array(control.time), inputs, tuple(control.shares))


Weights = tuple[Array, Array, Array, Array]


def hermite(s: Array, length: Array) -> Weights:
    """Weights of a cubic in time at the share `s` of a step's length in s.

    They are those of the first value, the last one, the first slope and the last one.
    """
    outside, inside = (1 + 2 * s) * (1 - s) ** 2, s**2 * (3 - 2 * s)
    return outside, inside, length * s * (1 - s) ** 2, -length * s**2 * (1 - s)


@dataclass(frozen=True)
class _Step:
    """One step: times in s, what acts, states and their slopes at both ends, inverse matrix of the method."""

    start: float
    end: float
    shares: Shares
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
    """Steps that were settled so far: their ends in s, means of inputs, and what acts in each."""

    def __init__(self, integrator: Integrator, levels: Levels, tolerance: float) -> None:
        self._integrator, self._levels, self._tolerance = integrator, levels, tolerance
        self.time = [0.0]
        self.means: list[Array] = []
        self.shares: list[Shares] = []

    def run(self, x: Array, points: Array) -> tuple[int, Array]:
        """Add steps up to the first that may err, or whose inputs change; gives number and states."""
        several = self._levels.starts[np.searchsorted(self._levels.starts, points[0], "right") :][:1]
        count = int(np.searchsorted(points, several[0], "right") if several.size else points.size) - 1
        if count == 0:
            return 0, x
        steps = self._levels.steps(points[: count + 1])
        states, first, last, _ = self._integrator(steps, x[:, None])
        ends = states[:, :, 0]
        length = np.diff(steps.time)[:, None]
        bend = np.diff(ends, axis=0) - length / 2 * (first + last)[:, :, 0]
        count = int(np.argmin(np.append(self._small(bend, ends[:-1]), False)))
        self.time += steps.time[1 : count + 1].tolist()
        self.shares += steps.shares[:count]
        return count, ends[count]

    def settle(self, step: _Step, cuts: int) -> Array:
        """Add a step, or several shorter ones in its place; gives the states at its end."""
        x, start, end, shares = step.x, step.start, step.end, step.shares
        if cuts > 0 and (len(shares) > 1 or not self._small(step.bend, x)):
            cut = self._levels.cut(start, end)
            halves = self._levels.steps(np.array([start, cut, end]))
            _, half, there = self._integrator(halves, x[:, None])[0][:, :, 0]
            between = step.settled(step.at(cut) - half)
            wrong = np.maximum(np.abs(step.reached - there), np.abs(between))
            if not self._small(wrong, x):
                half = self.settle(self.step(x, start, cut), cuts - 1)
                return self.settle(self.step(half, cut, end), cuts - 1)
        mean = self._levels.mean(shares) if len(shares) > 1 else None
        if mean is not None:
            leaning = self.step(x, start, end, mean).reached - step.reached
            if self._small(leaning * _MEMORY / (end - start), x):
                shares = ((len(self._levels.table) + len(self.means), 1.0),)
                self.means.append(mean)
        self.time.append(end)
        self.shares.append(shares)
        return step.reached

    def _small(self, error: Array, x: Array) -> NDArray[np.bool_]:
        within = np.abs(error) <= self._tolerance * np.maximum(1.0, np.abs(x) / _ORDINARY)
        return np.asarray(np.all(within, axis=-1))

    def step(self, x: Array, start: float, end: float, mean: Array | None = None) -> _Step:
        """A step on the inputs as they were logged, or on their mean."""
        ends = np.array([start, end])
        one = self._levels.steps(ends) if mean is None else Steps(ends, mean[None], (((0, 1.0),),))
        states, first, last, inverse = self._integrator(one, x[:, None])
        return _Step(start, end, one.shares[0], x, states[1, :, 0], first[0, :, 0], last[0, :, 0], inverse)

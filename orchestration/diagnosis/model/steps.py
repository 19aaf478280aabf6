"""Time steps of a run: short after its inputs change, growing while they stay, and their error is known.

README.md says by what they are compared and cut; only those that bend are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.model.integrator import Integrator, Steps

SIGNIFICANT = 0.1
"""Share of an input's range by which it must change for the steps to begin anew."""

MOST_EVENTS = 150
"""An input that changes more often is noisy: steps then average over it."""

MOST_LEVELS = 20_000

_CLOSE = 360.0
"""s between rows up to which steps are as a resolution says; beyond, they are longer in proportion."""

_CUTS = 5
"""How often a step may be cut in two."""

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
    first, longest : steps in s after a change of the inputs, and at most, before any is cut
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
    ends : s at which steps begin anew too, lest what comes after moves those before; shape (ends,)

    Attributes
    ----------
    starts : s at which a level begins, shape (levels,)
    table : shape (levels, inputs)
    end : s at which the last one ends
    stretched : times as long as a resolution says that steps are
    """

    def __init__(
        self, time: Array, inputs: Array, discrete: NDArray[np.bool_], ends: Array | None = None
    ) -> None:
        rows = _changes(inputs, discrete)
        self.starts, self.end = time[rows], float(time[-1])
        self.stretched = max(1.0, float(np.median(np.diff(time))) / _CLOSE)
        self.table = np.ascontiguousarray(inputs[:, rows].T)
        self._discrete, self._ends = discrete, np.zeros(0) if ends is None else ends

    def steps(self, points: Array) -> Steps:
        """Steps between points in s, shape (..., steps + 1), and every level as it is."""
        start, end = points[..., :-1].ravel(), points[..., 1:].ravel()
        first = np.searchsorted(self.starts, start, side="right") - 1
        count = np.searchsorted(self.starts, end, side="left") - first
        begins = np.append(0, np.cumsum(count))
        step = np.repeat(np.arange(count.size), count)
        levels = np.arange(step.size) + (first - begins[:-1])[step]
        ends = np.append(self.starts[1:], np.inf)[levels]
        lasts = np.minimum(ends, end[step]) - np.maximum(self.starts[levels], start[step])
        return Steps(points, self.table, begins, levels, lasts / (end - start)[step])

    def mean(self, steps: Steps) -> tuple[Array, NDArray[np.bool_]]:
        """One level in place of those of each step, and whether no input differs in it that has no mean."""
        begins, acting = steps.begins[:-1], self.table[steps.levels]
        mean = np.add.reduceat(steps.shares[:, None] * acting, begins)
        names = acting[:, self._discrete]
        mean[:, self._discrete] = names[begins]
        same = np.maximum.reduceat(names, begins) == np.minimum.reduceat(names, begins)
        return mean, same.all(axis=1)

    def cut(self, start: Array, end: Array) -> Array:
        """Times in s at which to cut steps in two: the change of level nearest the middle, or that itself."""
        middle = (start + end) / 2
        edges = np.concatenate([[-np.inf], self.starts, [np.inf]])
        after = np.searchsorted(edges, middle)
        near = edges[np.stack([after - 1, after])]
        away = np.where((near > start) & (near < end), np.abs(near - middle), np.inf)
        nearest = np.where(away[1] < away[0], near[1], near[0])
        return np.where(np.isfinite(away).any(axis=0), nearest, middle)

    def events(self) -> Array:
        """Times in s at which an input that is not noisy changes by much, and ends, shape (events,)."""
        return np.union1d(self.starts[leaps(self.table.T)], self._ends)


def layout(levels: Levels, resolution: Resolution) -> Array:
    """Points in s between steps that begin anew with each event, shape (steps + 1,)."""
    points, events = [0.0], levels.events()
    first, longest = (levels.stretched * each for each in (resolution.first, resolution.longest))
    for start, end in zip([0.0, *events], [*events, levels.end], strict=True):
        while end - points[-1] > 1e-9:
            left = end - points[-1]
            limit = min(longest, first + resolution.growth * (points[-1] - start))
            points.append(points[-1] + left / np.ceil(left / limit) if left > limit else end)
    return np.array(points)


def leaps(inputs: Array) -> NDArray[np.int64]:
    """Rows at which an input that is not noisy changes by much, of a table of shape (inputs, rows)."""
    return np.flatnonzero(_large(inputs)) + 1


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


Weights = tuple[Array, Array, Array, Array]


def hermite(s: Array, length: Array) -> Weights:
    """Weights of a cubic in time at the share `s` of a step's length in s.

    They are those of the first value, the last one, the first slope and the last one.
    """
    outside, inside = (1 + 2 * s) * (1 - s) ** 2, s**2 * (3 - 2 * s)
    return outside, inside, length * s * (1 - s) ** 2, -length * s**2 * (1 - s)


class _Taken(NamedTuple):
    """Steps that were taken: times in s, shape (steps,), states and slopes at both ends, shape (steps, n)."""

    start: Array
    end: Array
    x: Array
    reached: Array
    first: Array
    last: Array

    def those(self, which: NDArray[Any]) -> _Taken:
        return _Taken(*(each[which] for each in self))

    @property
    def ends(self) -> Array:
        return np.stack([self.start, self.end], axis=1)

    @property
    def length(self) -> Array:
        return (self.end - self.start)[:, None]


def controlled(
    integrator: Integrator, levels: Levels, x: Array, resolution: Resolution, thin: NDArray[np.int64]
) -> Steps:
    """Steps over a run that meet their tolerance wherever cutting them reaches it.

    Parameters
    ----------
    integrator : of the run, without sensitivities
    levels : the run's inputs
    x : states at the start, shape (n,)
    resolution : first steps and tolerance
    thin : states that are known at the ends of steps alone
    """

    def small(error: Array, x: Array) -> NDArray[np.bool_]:
        within = np.abs(error) <= resolution.tolerance * np.maximum(1.0, np.abs(x) / _ORDINARY)
        return np.asarray(np.all(within, axis=-1))

    taken, settled = _taken(integrator, levels.steps(layout(levels, resolution)), x), []
    for _ in range(_CUTS):
        # The difference from the trapezoidal rule: about the error of a step, at no cost.
        bend = taken.reached - taken.x - taken.length / 2 * (taken.first + taken.last)
        doubtful = (np.diff(levels.steps(taken.ends).begins) > 1) | ~small(bend, taken.x)
        settled.append(taken.those(~doubtful))
        taken = taken.those(doubtful)
        cut = levels.cut(taken.start, taken.end)
        halves = _taken(integrator, levels.steps(np.stack([taken.start, cut, taken.end], axis=1)), taken.x)
        weights = hermite((cut - taken.start)[:, None] / taken.length, taken.length)
        between = sum(map(np.multiply, weights, taken[2:])) - halves.reached[::2]
        between[:, thin] = 0.0
        wrong = ~small(np.maximum(np.abs(taken.reached - halves.reached[1::2]), np.abs(between)), taken.x)
        settled.append(taken.those(~wrong))
        taken = halves.those(np.repeat(wrong, 2))
    found = _Taken(*map(np.concatenate, zip(*settled, taken, strict=True)))
    return _averaged(integrator, levels, found.those(np.argsort(found.start)), small)


def _taken(integrator: Integrator, steps: Steps, x: Array) -> _Taken:
    """Steps on from one state, shape (n,), or in each of several groups from its own, shape (groups, n)."""
    states, first, last = (each[..., 0] for each in integrator(steps, x[..., None]))
    start, end = steps.time[..., :-1].ravel(), steps.time[..., 1:].ravel()
    before, after = (each.reshape(-1, x.shape[-1]) for each in (states[..., :-1, :], states[..., 1:, :]))
    return _Taken(start, end, before, after, first, last)


def _averaged(
    integrator: Integrator,
    levels: Levels,
    taken: _Taken,
    small: Callable[[Array, Array], NDArray[np.bool_]],
) -> Steps:
    """Steps of a run, on one mean level each wherever that changes nothing."""
    steps = levels.steps(taken.ends)
    mean, averaged = levels.mean(steps)
    averaged &= np.diff(steps.begins) > 1
    some, each = taken.those(averaged), np.arange(np.count_nonzero(averaged))
    alone = Steps(some.ends, mean[averaged], np.arange(each.size + 1), each, np.ones(each.size))
    leaning = (_taken(integrator, alone, some.x).reached - some.reached) * _MEMORY / some.length
    averaged[averaged] = small(leaning, some.x)
    acting, shares, first = steps.levels.copy(), steps.shares.copy(), steps.begins[:-1][averaged]
    acting[first], shares[first] = len(levels.table) + np.arange(first.size), 1.0
    count = np.diff(steps.begins)
    kept = ~np.repeat(averaged, count)
    kept[first] = True
    begins = np.append(0, np.cumsum(np.where(averaged, 1, count)))
    points = np.append(taken.start, taken.end[-1])
    return Steps(points, np.vstack([levels.table, mean[averaged]]), begins, acting[kept], shares[kept])

"""Time steps laid out from a run's inputs: short after they change, growing while they stay."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array

Shares = tuple[tuple[int, float], ...]
"""Levels that act in a step, and their shares of its length."""

SIGNIFICANT = 0.1
"""Share of an input's range by which it must change for the steps to begin anew."""

MOST_EVENTS = 150
"""An input that changes more often is noisy: steps then average over it."""

MOST_LEVELS = 20_000


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

FINAL = Resolution(40, 1.0, 0.08, 20.0, 0.003)

CHECK_CELLS = 80
"""With half of each `FINAL` step and every input as it was logged, to see whether `FINAL` is fine enough."""


@dataclass(frozen=True)
class Steps:
    """Steps in order.

    Attributes
    ----------
    time : s, points between the steps, shape (steps + 1,)
    inputs : levels that the inputs take, shape (levels, inputs)
    shares : for each step the levels that act in it and their shares of its length
    """

    time: Array
    inputs: Array
    shares: tuple[Shares, ...]


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
    values : shape (inputs, levels)
    end : s at which the last one ends
    """

    def __init__(self, time: Array, inputs: Array, discrete: NDArray[np.bool_]) -> None:
        rows = _changes(inputs, discrete)
        self.starts, self.values, self.end = time[rows], inputs[:, rows], float(time[-1])
        self._discrete = discrete

    def within(self, start: float, end: float) -> Shares:
        """Levels that act from one time in s to another, in order, with their shares of it."""
        first = int(np.searchsorted(self.starts, start, side="right")) - 1
        last = int(np.searchsorted(self.starts, end, side="left"))
        edges = np.concatenate([[start], self.starts[first + 1 : last], [end]])
        shares = np.diff(edges) / (end - start)
        return tuple(zip(range(first, last), shares.tolist(), strict=True))

    def mean(self, shares: Shares) -> Array | None:
        """One level in place of several; None where they differ in an input that has no mean."""
        columns, weights = zip(*shares, strict=True)
        values = self.values[:, list(columns)]
        if np.any(values[self._discrete] != values[self._discrete, :1]):
            return None
        level = values @ np.array(weights)
        level[self._discrete] = values[self._discrete, 0]
        return level

    def cut(self, start: float, end: float) -> float:
        """Time in s at which to cut a step in two: the change of level nearest its middle, or that itself."""
        inside = self.starts[np.searchsorted(self.starts, start, "right") : np.searchsorted(self.starts, end)]
        middle = (start + end) / 2
        return float(inside[np.argmin(np.abs(inside - middle))]) if inside.size else middle

    def events(self) -> Array:
        """Times in s at which an input that is not noisy changes by much, shape (events,)."""
        return self.starts[1:][_large(self.values)]

    def halved(self, points: Array) -> Steps:
        """Two steps for each between points in s, and every level as it is."""
        time = np.insert(points, np.arange(1, points.size), (points[:-1] + points[1:]) / 2)
        shares = tuple(self.within(a, b) for a, b in pairwise(time.tolist()))
        return Steps(time, np.ascontiguousarray(self.values.T), shares)


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

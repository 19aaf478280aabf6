"""Time steps for a measured run: short after the inputs change, growing while they stay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

SIGNIFICANT = 0.1
"""Share of an input's range by which it must change for the steps to begin anew."""

MOST_EVENTS = 150
"""An input that changes more often is noisy: steps then average over it."""

MOST_LEVELS = 20_000

ALIKE = 0.05
"""Share of an input's range within which its values in a step are replaced by their mean."""


@dataclass(frozen=True)
class Resolution:
    """How finely to integrate: cells of the link, first step in s, its growth, longest step in s."""

    cells: int
    first: float
    growth: float
    longest: float


SEARCH = Resolution(20, 3.0, 0.2, 60.0)
"""For comparing models: its error is made up for by one run at `FINAL` resolution."""

FINAL = Resolution(40, 1.0, 0.08, 20.0)

CHECK = Resolution(80, 0.5, 0.04, 10.0)
"""To see whether `FINAL` is fine enough."""


@dataclass(frozen=True)
class Steps:
    """Steps in order.

    Attributes
    ----------
    time : s, points between the steps, shape (steps + 1,)
    inputs : levels that the inputs take, shape (inputs, levels)
    shares : for each step the levels that act in it and their shares of its length
    """

    time: Vector
    inputs: Vector
    shares: tuple[tuple[tuple[int, float], ...], ...]


def steps_for(
    time: Vector, inputs: Vector, resolution: Resolution, proportional: NDArray[np.bool_] | None = None
) -> Steps:
    """Steps over a run.

    Parameters
    ----------
    time : rows in s, rising from 0, shape (rows,)
    inputs : held from each row to the next, shape (inputs, rows)
    resolution : how finely
    proportional : inputs that act in proportion, so that their mean over a step serves, shape (inputs,)
    """
    starts = _levels(time, inputs)
    events = _events(inputs[:, starts])
    ends = np.append(time[starts[1:]], time[-1])
    builder = _Builder(resolution, inputs, proportional)
    for start, end, column, event in zip(time[starts], ends, starts, events, strict=True):
        if event:
            builder.flush()
            builder.since = 0.0
        builder.add(int(column), float(end - start))
    builder.flush()
    times = np.concatenate([[0.0], np.cumsum(builder.lengths)])
    return Steps(times, np.column_stack(builder.levels), tuple(builder.shares))


def _levels(time: Vector, inputs: Vector) -> NDArray[np.int64]:
    """Rows at which any input changes; thinned where there are too many to step through."""
    changed = np.any(np.diff(inputs, axis=1) != 0, axis=0)
    changed[-1:] = False  # what the last row brings acts on nothing
    starts = np.concatenate([[0], np.flatnonzero(changed) + 1])
    if starts.size <= MOST_LEVELS:
        return starts
    return np.unique(starts[:: -(-starts.size // MOST_LEVELS)])


def _events(levels: Vector) -> NDArray[np.bool_]:
    if levels.shape[1] == 1:
        return np.zeros(1, dtype=bool)
    span = np.ptp(levels, axis=1, keepdims=True)
    change = np.abs(np.diff(levels, axis=1)) / np.where(span > 0, span, 1.0)
    large = change > SIGNIFICANT
    large[large.sum(axis=1) > MOST_EVENTS] = False
    return np.concatenate([[False], np.any(large, axis=0)])


class _Builder:
    def __init__(
        self, resolution: Resolution, inputs: Vector, proportional: NDArray[np.bool_] | None
    ) -> None:
        self.resolution, self._inputs = resolution, inputs
        self._close = ALIKE * np.ptp(inputs, axis=1)
        if proportional is not None:
            self._close[proportional] = np.inf
        self._level: dict[int, int] = {}
        self.levels: list[Vector] = []
        self.since = 0.0
        self.lengths: list[float] = []
        self.shares: list[tuple[tuple[int, float], ...]] = []
        self._pending: list[tuple[int, float]] = []
        self._length = 0.0

    def add(self, column: int, duration: float) -> None:
        """Add a stretch of constant inputs, cut into steps where it is long."""
        left = duration
        while left > 1e-9:
            limit = min(self.resolution.longest, self.resolution.first + self.resolution.growth * self.since)
            room = limit - self._length
            take = left if left <= room else min(left, max(room, left / np.ceil(left / room)))
            self._pending.append((column, take))
            self._length += take
            left -= take
            if self._length >= limit * (1 - 1e-9):
                self.flush()

    def flush(self) -> None:
        """Close the step that is being filled."""
        if not self._pending:
            return
        total = self._length
        self.lengths.append(total)
        self.shares.append(self._shares(total))
        self.since += total
        self._pending, self._length = [], 0.0

    def _shares(self, total: float) -> tuple[tuple[int, float], ...]:
        columns = [column for column, _ in self._pending]
        values = self._inputs[:, columns]
        if len(columns) > 1 and np.all(np.ptp(values, axis=1) <= self._close):
            weights = np.array([length for _, length in self._pending]) / total
            self.levels.append(values @ weights)
            return ((len(self.levels) - 1, 1.0),)
        for column in columns:
            if column not in self._level:
                self._level[column] = len(self.levels)
                self.levels.append(self._inputs[:, column])
        return tuple((self._level[column], length / total) for column, length in self._pending)

"""Measured logs, and the readings in them that a law is learnt from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.interface import SENSED
from warmlink.fmus.errors import InputError

Array = NDArray[np.float64]

WINDOW = 30.0
"""s over which readings of the growth are averaged, and the temperatures about them."""

REACH, REACH_S = 1.5, 120.0
"""How far from a reading a temperature is known: median spacings of the readings, and s at least."""

BLOCKS = 8
"""Parts of all logs, each held out once."""

SHORTEST_BLOCK = 180.0
"""s; what is held out nearer than that to what is fitted goes with it, and says nothing."""


@dataclass(frozen=True)
class Log:
    """One measured run.

    Attributes
    ----------
    time : in s, rising, shape (n,)
    temperature : in K in `SENSED`'s order, NaN where there is no reading, shape (n, 5)
    growth : in m, NaN where it was not measured, shape (n,)
    others : signals that may go with what a law leaves, by name, shapes (n,)
    """

    name: str
    time: Array
    temperature: Array
    growth: Array
    others: Mapping[str, Array] = field(default_factory=dict)


@dataclass(frozen=True)
class Examples:
    """Readings of the growth, each with the temperatures about it.

    Attributes
    ----------
    temperature : in K in `SENSED`'s order, NaN where it is not known, shape (m, 5)
    growth : in m, shape (m,)
    block : part of the logs that is held out together, shape (m,)
    log : index of the log, shape (m,)
    time : in s since the log's begin, shape (m,)
    """

    temperature: Array
    growth: Array
    block: NDArray[np.intp]
    log: NDArray[np.intp]
    time: Array

    def part(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> Examples:
        """Some of them."""
        return Examples(
            self.temperature[rows], self.growth[rows], self.block[rows], self.log[rows], self.time[rows]
        )


def examples_of(logs: Sequence[Log]) -> Examples:
    """Readings of all logs, averaged over each `WINDOW`.

    Raises
    ------
    InputError
        A log has no reading of the growth.
    """
    duration = sum(float(log.time[-1] - log.time[0]) for log in logs)
    # A little longer, so that the last reading is in the last one.
    length = (1 + 1e-9) * max(duration / BLOCKS, SHORTEST_BLOCK)
    found: list[tuple[Array, Array, Array]] = []
    for log in logs:
        read = np.isfinite(log.growth)
        if not read.any():
            raise InputError(f"{log.name}: the growth was not measured; add a column 'elongation [um]'")
        _, group = np.unique(log.time[read] // WINDOW, return_inverse=True)
        count = np.bincount(group)
        time = np.bincount(group, log.time[read]) / count
        found.append(
            (temperatures_near(log, time), np.bincount(group, log.growth[read]) / count, time - log.time[0])
        )
    which = np.repeat(np.arange(len(logs)), [growth.size for _, growth, _ in found])
    temperature, growth, time = (np.concatenate(each) for each in zip(*found, strict=True))
    _, block = np.unique(which * 10**6 + (time // length).astype(int), return_inverse=True)
    return Examples(temperature, growth, block, which, time)


def temperatures_near(log: Log, time: Array) -> Array:
    """Mean temperatures in K in a window about some times in s, shape (m, 5).

    Between readings that are farther apart it is on the line from one to the next, and NaN where no reading
    is near.
    """
    first, last = (np.searchsorted(log.time, time + side * WINDOW / 2) for side in (-1, 1))
    there = np.isfinite(log.temperature)
    sums, counts = (
        np.vstack([np.zeros(len(SENSED)), np.cumsum(each, axis=0)])
        for each in (np.where(there, log.temperature, 0.0), there)
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        means = (sums[last] - sums[first]) / (counts[last] - counts[first])
    for i in range(len(SENSED)):  # of a slow log no reading may lie in a window
        bare, read = np.isnan(means[:, i]), there[:, i]
        if read.any():
            at, near = log.time[read], np.median(np.diff(log.time[read])) if read.sum() > 1 else 0.0
            bare &= _distance(time, at) <= max(REACH * near, REACH_S)
            means[bare, i] = np.interp(time[bare], at, log.temperature[read, i])
    return np.asarray(means)


def _distance(time: Array, at: Array) -> Array:
    """How far each time is from the nearest of some, which rise, in s."""
    after = np.clip(np.searchsorted(at, time), 0, at.size - 1)
    return np.minimum(np.abs(at[after] - time), np.abs(time - at[np.maximum(after - 1, 0)]))

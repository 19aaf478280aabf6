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
"""s about a reading of the growth over which temperatures are averaged."""

BLOCKS = 8
"""Parts of all logs, each held out once."""

SHORTEST_BLOCK = 180.0
"""s; what is nearer than that to what is fitted says nothing."""


@dataclass(frozen=True)
class Log:
    """One measured run.

    Attributes
    ----------
    time : in s, rising, shape (n,)
    temperature : in K in `SENSED`'s order, NaN where there is no reading, shape (n, 5)
    growth : in m, NaN where it was not measured, shape (n,)
    others : signals that the rest may correlate with, by name, shapes (n,)
    """

    name: str
    time: Array
    temperature: Array
    growth: Array
    others: Mapping[str, Array] = field(default_factory=dict)


@dataclass(frozen=True)
class Examples:
    """Readings of the growth, each with the temperatures about it; shapes (m, 5) and (m,)."""

    temperature: Array
    growth: Array
    block: NDArray[np.intp]
    log: NDArray[np.intp]
    time: Array

    def part(self, rows: NDArray[np.bool_]) -> Examples:
        """Some of them."""
        return Examples(
            self.temperature[rows], self.growth[rows], self.block[rows], self.log[rows], self.time[rows]
        )


def examples_of(logs: Sequence[Log]) -> Examples:
    """Readings of all logs, those within one window of time as one.

    Raises
    ------
    InputError
        A log has no reading of the growth.
    """
    whole = sum(float(log.time[-1] - log.time[0]) for log in logs)
    length = max(whole / BLOCKS, SHORTEST_BLOCK)
    found: list[tuple[Array, Array, Array]] = []
    for log in logs:
        read = np.isfinite(log.growth)
        if not read.any():
            raise InputError(f"{log.name}: the growth was not measured; add a column 'elongation [um]'")
        _, group = np.unique(log.time[read] // WINDOW, return_inverse=True)
        count = np.bincount(group)
        time = np.bincount(group, log.time[read]) / count
        found.append((about(log, time), np.bincount(group, log.growth[read]) / count, time - log.time[0]))
    which = np.repeat(np.arange(len(logs)), [growth.size for _, growth, _ in found])
    temperature, growth, time = (np.concatenate(each) for each in zip(*found, strict=True))
    _, block = np.unique(which * 10**6 + (time // length).astype(int), return_inverse=True)
    return Examples(temperature, growth, block, which, time)


def about(log: Log, time: Array) -> Array:
    """Mean temperatures in K in a window about some times in s, shape (m, 5); NaN where none was read."""
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
            means[bare, i] = np.interp(time[bare], log.time[read], log.temperature[read, i])
    return np.asarray(means)

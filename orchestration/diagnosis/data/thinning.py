"""Measured rows made ready for statistics: dense rows are averaged, and their scatter is told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.data.signals import Rows, quantum, row_noise

MOST_ROWS = 400
"""Rows kept of a run; more say little new about heat, and noise is estimated from what is kept."""

SHORTEST = 5.0
"""s; rows that follow faster are averaged."""

_FEWEST_POINTS = 6
"""Fewest times at which a block of many rows is simulated; in a long block they are `SHORTEST` apart."""


@dataclass(frozen=True)
class Averaging:
    """Over what a reading was averaged: number of rows, and time in s."""

    rows: float = 1.0
    duration: float = 0.0

    def kept(self, memory: float) -> float:
        """Share of the variance that noise correlated over a time in s keeps in the mean.

        The mean over T of a process with covariance exp(-t/m): 2 (T/m - 1 + exp(-T/m)) / (T/m)^2.
        """
        ratio = self.duration / memory
        return 2 * (ratio + float(np.expm1(-ratio))) / ratio**2 if ratio > 1e-6 else 1.0


ROW = Averaging()
"""A row as it was recorded."""


@dataclass(frozen=True)
class Thinned:
    """Readings of a run in blocks.

    Attributes
    ----------
    time : s, mean of each block's rows, shape (blocks,)
    averaging : rows and time over which each block was averaged
    within : s, times in each block at which it is simulated, shape (blocks, points)
    weight : of each of these times in the block's mean, shape (blocks, points, outputs)
    readings : SI, mean of each block, NaN where most due in it are missing, shape (blocks, outputs)
    fitted : blocks that fitting may use, shape (blocks,)
    quantum : step to which readings are rounded, 0 if there is none, shape (outputs,)
    scatter : noise in SI from row to row, before averaging, shape (outputs,)
    """

    time: Array
    averaging: Averaging
    within: Array
    weight: Array
    readings: Array
    fitted: NDArray[np.bool_]
    quantum: Array
    scatter: Array


def thinned(run: Run, variables: Sequence[str]) -> Thinned:
    """Average a run's rows where they are dense."""
    table = np.column_stack([run.readings.get(v, np.full(run.time.size, np.nan)) for v in variables])
    quanta = np.array([quantum(column) for column in table.T])
    scatter = np.array([row_noise(run.time, column) for column in table.T])
    span = min(float(run.time[-1]), run.fit_until)  # so that held-out rows are averaged alike
    spacing = float(np.median(np.diff(run.time)))
    length = max(SHORTEST, span / MOST_ROWS)
    if spacing >= length * 0.75:
        one = np.ones((run.time.size, 1, table.shape[1]))
        return Thinned(run.time, ROW, run.time[:, None], one, table, run.fitted, quanta, scatter)
    block = np.floor(run.time / length).astype(np.int64)
    starts = np.flatnonzero(np.diff(block, prepend=-1))
    count = np.diff(np.append(starts, block.size))
    time = np.add.reduceat(run.time, starts) / count
    most = max(_FEWEST_POINTS, int(np.ceil(length / SHORTEST)))
    within, weight = _points(run.time, np.isfinite(table), starts, count, most)
    means = _means(run.time, table, starts, count, count > most)
    fitted = np.logical_and.reduceat(run.fitted, starts)
    averaging = Averaging(1 / float(np.mean(1 / count)), length)
    return Thinned(time, averaging, within, weight, means, fitted, quanta, scatter)


def _means(time: Array, table: Array, starts: Rows, count: Rows, sparse: NDArray[np.bool_]) -> Array:
    """Mean of each block's readings, NaN where most of those due at the output's own spacing are missing.

    Where not every row of a block is simulated, missing readings are interpolated between their neighbours,
    so that the mean is not biased to one side.
    """
    full = np.isfinite(table)
    filled = np.add.reduceat(full.astype(float), starts, axis=0)
    rows, due = np.where(full, table, 0.0), np.empty(filled.shape)
    for i, there in enumerate(full.T):
        gaps = ~there & np.repeat(sparse, count) & there.any()
        rows[gaps, i] = np.interp(time[gaps], time[there], rows[there, i]) if gaps.any() else 0.0
        # A logger may read an output less often than others.
        apart = np.diff(np.flatnonzero(there))
        due[:, i] = count / (np.median(apart) if apart.size else 1.0)
    counted = np.where(sparse[:, None], count[:, None], np.maximum(filled, 1.0))
    means = np.add.reduceat(rows, starts, axis=0) / counted
    return np.where(filled >= np.maximum(due / 2, 1), means, np.nan)


def _points(
    time: Array, full: NDArray[np.bool_], starts: Rows, count: Rows, most: int
) -> tuple[Array, Array]:
    """Times at which blocks are simulated, and their weights: the rows, or some as evenly spread.

    Where a block has few rows, its own rows with readings are used: near a leap of the inputs no other times
    can represent them.
    """
    number = np.minimum(count, most)[:, None]
    point = np.arange(number.max())
    place = np.clip((point + 0.5) * (count[:, None] / number) - 0.5, 0.0, count[:, None] - 1.0)
    within = np.interp(starts[:, None] + place, np.arange(time.size), time)
    used = np.repeat((point < number)[:, :, None], full.shape[1], axis=2)
    read = used & full[np.round(starts[:, None] + place).astype(np.int64)]
    # A block in which nothing was read is simulated too, for the eye.
    all_of_them = (count > most)[:, None, None] | ~read.any(axis=1, keepdims=True)
    used = np.where(all_of_them, used, read)
    return within, used / np.maximum(used.sum(axis=1, keepdims=True), 1)

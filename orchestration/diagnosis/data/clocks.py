"""By how much the readings of a run come late or early against its inputs, without any model.

The rate of a temperature follows at once from the heat of that time and from the temperatures beside it. So
the rate is fitted by all readings and by shifted inputs; the shift that leaves least is the one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run

MOST = 600.0
"""s, the largest shift that is looked for."""

_FINEST, _MOST_BLOCKS = 20.0, 400
"""s of a block whose mean rate is looked at, at least; and the number of blocks of a run, at most."""

_HALVED, _EXPLAINED = 0.5, 0.25
"""Share of the variance left without a shift, and of the whole, that a true shift leaves at most."""

_AS_GOOD = 1.2
"""Ratio to the least variance left within which a smaller shift is as good: a duty cycle may repeat."""

_FEWEST = 30


def shift(run: Run, readings: Sequence[str], heating: Sequence[Array]) -> tuple[float, str] | None:
    """Time in s by which readings come late (early if negative) against inputs, and the reading that tells.

    Parameters
    ----------
    run : a run whose inputs change
    readings : temperatures by which it is judged
    heating : what of the inputs makes heat, each held until the next row, shape (rows,)

    Returns
    -------
    tuple or None
        None if no shift explains a reading much better than none does.
    """
    length = max(_FINEST, 2 * float(np.median(np.diff(run.time))), float(run.time[-1]) / _MOST_BLOCKS)
    shifts = length * np.arange(-int(MOST // length), int(MOST // length) + 1)
    blocks = np.arange(length, run.time[-1] - length, length)
    begins = np.concatenate([blocks - length / 2, blocks[-1:] + length / 2]) if blocks.size else blocks
    if blocks.size < _FEWEST or not heating:
        return None
    means = {name: _block_means(run.time, run.readings[name], begins) for name in readings}
    # Rows that every shift can use, so that all are judged by the same ones.
    inner = (blocks - length > shifts[-1]) & (blocks + length < run.time[-1] + shifts[0])
    found = []
    for name, mean in means.items():
        rate = (mean[2:] - mean[:-2]) / (2 * length)
        beside = np.column_stack([np.ones(rate.size), *(each[1:-1] for each in means.values())])
        used = inner[1:-1] & np.isfinite(rate) & np.isfinite(beside).all(axis=1)
        if used.sum() < _FEWEST or not np.var(rate[used]):
            continue
        left = [
            _left(rate, _at(run.time, heating, blocks[1:-1] - late, length), beside, used) for late in shifts
        ]
        near = [i for i in range(shifts.size) if left[i] <= _AS_GOOD * min(left)]
        best = min(near, key=lambda i: abs(shifts[i]))
        as_it_is = left[shifts.size // 2]
        if abs(shifts[best]) > 2 * length and left[best] < min(_HALVED * as_it_is, _EXPLAINED):
            found.append((left[best], float(shifts[best]), name))
    return min(found)[1:] if found else None


def _block_means(time: Array, values: Array, begins: Array) -> Array:
    """Means of readings in blocks that begin at times, NaN where there is none, shape (begins - 1,)."""
    there = np.isfinite(values)
    place = np.searchsorted(begins, time[there], side="right") - 1
    within = (place >= 0) & (place < begins.size - 1)
    count = np.bincount(place[within], minlength=begins.size - 1)
    total = np.bincount(place[within], values[there][within], minlength=begins.size - 1)
    return np.where(count, total / np.maximum(count, 1), np.nan)


def _at(time: Array, signals: Sequence[Array], middles: Array, length: float) -> Array:
    """Means of held signals over twice a length about times, shape (times, signals)."""
    columns = []
    for signal in signals:
        total = np.append(0.0, np.cumsum(signal[:-1] * np.diff(time)))
        ends = (np.interp(middles + side * length, time, total) for side in (1, -1))
        columns.append((next(ends) - next(ends)) / (2 * length))
    return np.column_stack(columns)


def _left(rate: Array, heat: Array, beside: Array, used: Array) -> float:
    """Share of a rate's variance that a fit by heat and by the readings beside it leaves."""
    table = np.column_stack([beside, heat])[used]
    table = table / np.maximum(np.abs(table).max(axis=0), 1e-300)
    error = rate[used] - table @ np.linalg.lstsq(table, rate[used], rcond=None)[0]
    return float(np.var(error) / np.var(rate[used]))

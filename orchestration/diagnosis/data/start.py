"""What a sensor would have read at 0 s: from its first readings, which may rise from the first row on."""

from __future__ import annotations

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.signals import quantum, row_noise

FIRST = 60.0
"""s whose readings tell the start."""

_MOST_BENT = 4
"""Highest power of time in the course of the first readings."""

_WORTH = 9.0
"""By how much chi-square has to fall for a further power."""

_CREDIBLE = 4.0
"""Standard deviations by which chi-square may lie above its mean."""


def at_start(time: Array, values: Array) -> float | None:
    """Reading at 0 s, from the polynomial through the first minute that is as simple as the noise allows.

    Where none fits, as where heating begins in that minute, fewer of its rows are taken.

    Parameters
    ----------
    time : s from the start of the run, shape (rows,)
    values : readings, NaN where there is none, shape (rows,)

    Returns
    -------
    float or None
        In the unit of the readings; None if there is no reading in the first minute.
    """
    step = quantum(values)
    read = np.isfinite(values) & (time <= FIRST)
    times, readings = time[read], values[read]
    if not readings.size:
        return None
    if not readings.any():  # as a growth that a model computes without noise
        return 0.0
    noise = max(row_noise(time, values), step / np.sqrt(12), 1e-9 * float(np.abs(readings).max()))
    noise = noise or 1.0  # of nothing but zeros, which any noise explains
    count = readings.size
    while True:
        start, credible = _intercept(times[:count], readings[:count], noise)
        if credible:
            return start
        count //= 2


def _intercept(times: Array, readings: Array, noise: float) -> tuple[float, bool]:
    """Value at 0 s of the best polynomial, and whether noise explains what it leaves."""
    found = []
    for power in range(min(_MOST_BENT, readings.size - 1) + 1):
        powers = (times[:, None] / FIRST) ** np.arange(power + 1)
        best = np.linalg.lstsq(powers, readings, rcond=None)[0]
        squares, free = float(np.sum((powers @ best - readings) ** 2)), readings.size - power - 1
        left = squares / max(noise**2, np.finfo(float).tiny)  # all readings of 0 have no noise
        found.append((left + _WORTH * power, float(best[0]), left <= free + _CREDIBLE * np.sqrt(2 * free)))
    _, start, credible = min(found)
    return start, bool(credible)

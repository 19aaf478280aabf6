"""Readings of a column: their noise, the step they are rounded to, and sensors that stick."""

from __future__ import annotations

import numpy as np

from warmlink.fmus.component import Scalar
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.scenarios.logged.cells import Column, Rows, signal
from warmlink.orchestration.scenarios.logged.sheet import Place, Sheet

_FEWEST_CHANGES = 5
"""Changes of a column with which it may be said to repeat itself: below, it is as good as dead."""

_LEAP, _LASTING = 4.0, 3
"""Change from row to row that is a jump, as a multiple of those that noise makes; rows that make a level."""


def as_reading(sheet: Sheet, place: Place, scalar: Scalar | None) -> tuple[Column, Array, list[str]]:
    """A measured column, its readings in SI, NaN where there is none, and remarks on its cells.

    Readings that only repeat the one before are none. InputError as `signal`.
    """
    column, values, lost = signal(sheet, place, scalar)
    missing = [sheet.taken_for_missing(lost, place.column)] if lost.size else []
    kept, said = _without_repeats(f"{sheet.name}: ", column.name, values)
    return column, kept, [*missing, *said]


def _without_repeats(where: str, name: str, values: Array) -> tuple[Array, list[str]]:
    """Readings of a column without those that only repeat the one before, and what is to be said of these."""
    rows = repeats(values)
    what, why = "repeat the one before", "or the logger writes more often than it samples"
    if not rows.size:
        rows = between_jumps(values)
        what, why = "lie between jumps", "and is right when it has just jumped"
    if not rows.size:
        return values, []
    kept = values.copy()
    kept[rows] = np.nan
    said = f"{where}{rows.size} of {values.size} values of {name} {what} and are left out"
    return kept, [f"{said}; the sensor sticks, {why}"]


def quantum(values: Array) -> float:
    """Step of the lattice that readings lie on, 0 where they lie on none.

    Rounded readings repeat few distinct values, all whole multiples of the smallest difference of two.
    """
    filled = values[np.isfinite(values)]
    distinct = np.unique(np.round(filled, 9))
    if distinct.size < 3 or distinct.size > 0.7 * filled.size:
        return 0.0
    steps = np.diff(distinct)
    step = float(np.median(steps))
    whole = np.round(steps / step)
    on_lattice = np.abs(steps / step - whole) < 0.02
    return step if on_lattice.mean() > 0.95 and np.mean(whole == 1) > 0.5 else 0.0


def row_noise(times: Array, values: Array) -> float:
    """White noise of a slow signal from row to row: how far readings lie from the line between neighbours.

    It owes nothing to any model, shape (n,) each, NaN where there is no reading.
    """
    bend = bends(times, values)
    if not bend.size:
        return 0.0
    trimmed = bend[bend <= np.quantile(bend, 0.95)]
    return max(1.4826 * float(np.median(bend)), float(np.sqrt(np.mean(trimmed**2))))


def bends(times: Array, values: Array) -> Array:
    """How far each reading lies from the line between its neighbours, scaled to the noise of one reading."""
    there = np.isfinite(values)
    at, filled = times[there], values[there]
    if filled.size <= 3:
        return np.empty(0)
    share = (at[1:-1] - at[:-2]) / (at[2:] - at[:-2])
    off = filled[1:-1] - (1 - share) * filled[:-2] - share * filled[2:]
    return np.asarray(np.abs(off) / np.sqrt(1 + share**2 + (1 - share) ** 2))


def repeats(values: Array) -> Rows:
    """Rows that repeat the reading before, where most rows do and readings lie on no lattice.

    A sensor that sticks reads so, and a logger that writes only large changes, or more often than it samples.
    """
    rows = np.flatnonzero(np.isfinite(values))
    again = np.diff(values[rows]) == 0
    changes = np.count_nonzero(~again)
    if changes < _FEWEST_CHANGES or changes > again.size / 2 or quantum(values):
        return rows[:0]
    return rows[1:][again]


def between_jumps(values: Array) -> Rows:
    """Rows between the jumps of a sensor that sticks; none where the sensor follows its temperature.

    Such a sensor is right when it has just jumped. Between its jumps its readings scatter about one level by
    no more than from row to row, which those of a sensor that follows do not.
    """
    rows = np.flatnonzero(np.isfinite(values))
    read = values[rows]
    steps = np.abs(np.diff(read))
    if np.count_nonzero(steps) < _FEWEST_CHANGES:
        return rows[:0]
    noise = 1.4826 * float(np.median(steps))
    jumps = steps > _LEAP * noise
    for _ in range(2):
        level = np.cumsum(np.append(0, jumps))
        count = np.bincount(level)
        mean = np.bincount(level, read) / count
        apart = np.abs(np.diff(mean))
        if apart.size < _FEWEST_CHANGES:
            return rows[:0]
        jumps[jumps] = apart > np.median(apart) / 2  # what noise made of one level are parts of it
    scatter = np.sum((read - mean[level]) ** 2) / max(read.size - count.size, 1)
    lasting = count >= _LASTING
    moved = np.ptp(mean[lasting]) > 2 * np.median(apart) if lasting.any() else False
    sticks = moved and count[lasting].sum() > 0.8 * read.size and scatter < 1.5 * noise**2 / 2
    return rows[1:][~jumps] if sticks else rows[:0]

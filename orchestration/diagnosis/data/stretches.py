"""Stretches of readings that no temperature made: a sensor that is stuck or cut off, and a loose contact.

They are found without any model, as spikes are, so that a model's own misfit hides none.
"""

from __future__ import annotations

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.signals import bends, quantum
from warmlink.orchestration.scenarios.logged.cells import Rows

_STUCK, _HELD = 5, 4
"""Readings of one value that are too many where noise shows in each, and where they leap to it and away."""

_RARE = 0.05
"""Share of readings that repeat the one before, up to which each reading is known to show noise."""

_LEAP, _STEPS = 8.0, 3.0
"""Leap to a value that stays, in standard deviations of the noise, and in steps of rounding."""

_MOVES, _USUAL = 2.0, 0.9
"""Times by which such a leap is larger than most moves from row to row, and the share of these."""

_LOOSE, _TURNS, _APART = 4, 2, 3
"""Leaps of a loose contact at least, their turns, and rows from one to the next at most."""

_BESIDE, _LASTING, _ALONE = 15, 6, 2.0
"""Rows on each side that a lasting step is compared with, rows that it lasts, and times that it is faster."""

_SHARE = 1e-3
"""Share of the readings' range below which no leap is worth a word."""

_FEWEST = 30


def stuck(times: Array, values: Array) -> Rows:
    """Rows in which a sensor repeats one value, as it does when it is stuck, cut off, or its logger hangs.

    Either noise shows in every other reading, or the readings leap to that value and away from it.

    Parameters
    ----------
    times : s, rising, shape (n,)
    values : readings in any unit, shape (n,); NaN where there is none
    """
    rows = np.flatnonzero(np.isfinite(values))
    if rows.size < _FEWEST or np.ptp(values[rows]) == 0:
        return rows[:0]
    read = values[rows]
    edges = np.flatnonzero(np.diff(read) != 0) + 1
    begins, ends = np.append(0, edges), np.append(edges, read.size)
    lengths = ends - begins
    moves = np.abs(np.diff(read))
    noise, step = _noise(times[rows][begins], read[begins]), quantum(values)
    usual = float(np.quantile(moves[moves > 0], _USUAL))
    leap, found = max(_LEAP * noise, _STEPS * step, _MOVES * usual), []
    held = lengths >= _HELD
    for first, last in zip(begins[held].tolist(), ends[held].tolist(), strict=True):
        length = last - first
        before = abs(read[first] - read[first - 1]) if first else np.inf
        after = abs(read[last] - read[last - 1]) if last < read.size else np.inf
        others = read.size - length
        again = (read.size - lengths.size) - (length - 1)
        noisy = others >= _FEWEST and again <= _RARE * others and not step
        if noisy and length >= _STUCK:
            # The reading with which it stuck is right, unless it leapt there.
            found.append(np.arange(first + (first > 0 and before <= leap), last))
        elif min(before, after) > leap and others >= _FEWEST and max(before, after) < np.inf:
            found.append(np.arange(first, last))
    return rows[np.concatenate(found)] if found else rows[:0]


def loose(times: Array, values: Array, driven: Rows | None = None) -> Rows:
    """Rows of a loose contact: readings that leap to and fro, and those between.

    Parameters
    ----------
    times, values : as of `stuck`
    driven : rows in which an input leaps, which may make readings leap
    """
    rows = np.flatnonzero(np.isfinite(values))
    if rows.size < _FEWEST:
        return rows[:0]
    read = values[rows]
    moves = np.diff(read)
    limit = max(_LEAP * _noise(times[rows], read), _STEPS * quantum(values), _SHARE * np.ptp(read))
    large = np.flatnonzero(np.abs(moves) > limit)
    if driven is not None:
        first = np.searchsorted(rows, driven)  # reading at or after each, and then the next
        large = large[~np.isin(large + 1, np.concatenate([first, first + 1]))]
    found = []
    for group in np.split(large, np.flatnonzero(np.diff(large) > _APART) + 1):
        turns = np.count_nonzero(np.diff(np.sign(moves[group])) != 0)
        if group.size >= _LOOSE and turns >= max(_TURNS, group.size // 3):
            found.append(np.arange(group[0] + 1, group[-1] + 1))
    return rows[np.concatenate(found)] if found else rows[:0]


def shifted(times: Array, values: Array, driven: Rows | None = None) -> list[tuple[int, float]]:
    """Rows from which readings lie higher or lower for good, at once, and by how much.

    Parameters
    ----------
    times, values, driven : as of `loose`
    """
    rows = np.flatnonzero(np.isfinite(values))
    if rows.size < _FEWEST:
        return []
    read, at = values[rows], times[rows]
    moves, apart = np.diff(read), np.diff(at)
    limit = max(_LEAP * _noise(at, read), _STEPS * quantum(values), _SHARE * np.ptp(read))
    found = []
    for i in np.flatnonzero(np.abs(moves) > limit).tolist():
        beside = np.r_[max(i - _BESIDE, 0) : i, i + 1 : min(i + 1 + _BESIDE, moves.size)]
        rate = float(np.max(np.abs(moves[beside] / apart[beside])))
        if i < _LASTING or i + _LASTING >= moves.size or abs(moves[i]) < _ALONE * rate * apart[i]:
            continue
        if driven is not None and np.any((driven >= rows[i] - 1) & (driven <= rows[i + 1] + 1)):
            continue
        sides = slice(i + 1 - _LASTING, i + 1), slice(i + 1, i + 1 + _LASTING)
        before, after = (float(np.median(read[side])) for side in sides)
        if abs(after - before - moves[i]) < abs(moves[i]) / 2:
            found.append((int(rows[i + 1]), after - before))
    return found


def _noise(times: Array, read: Array) -> float:
    """Noise from row to row of readings, by the median of their bends, which few bad rows reach."""
    bend = bends(times, read)
    return 1.4826 * float(np.median(bend)) if bend.size else 0.0

"""Single readings far from their neighbours: spikes of a line or a connector, which no heat makes.

They are found without any model, so that a model's own misfit makes no reading wrong and hides none.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.signals import quantum, row_noise
from warmlink.orchestration.scenarios.logged.cells import Rows

SPIKE = 6.0
"""Robust standard deviations from the running median at which a reading is a spike."""

_WINDOW, _LONGEST = 7, 3
"""Readings in a running median, and spikes in a row that it does not follow."""

_MOVES = 1.5
"""Times by which a spike is farther away than its neighbours move from one to the next: a bend is none."""

_AT_ONCE = 0.8
"""Share of three spikes' height by which readings leap, and leap back, from one row to the next."""


def outliers(times: Array, values: Array, driven: Rows | None = None) -> Rows:
    """Rows of isolated readings, at most three in a row, far from the running median of their neighbours.

    The median follows a monotone course exactly, so that slow heat makes no spikes; with the slope taken
    out the neighbours of a spike on a steep course do not look wild as well.

    Parameters
    ----------
    times : s, rising, shape (n,)
    values : readings in any unit, shape (n,); NaN where there is none
    driven : rows in which an input leaps; three spikes in a row that begin with one may be its doing, and a
        single one where the course before or after it leads on to it: a peak is where the heat stops
    """
    import pandas as pd

    rows = np.flatnonzero(np.isfinite(values))
    if rows.size < 3 * _WINDOW:
        return rows[:0]
    at, filled, step = times[rows], values[rows], quantum(values)
    half = _WINDOW // 2
    course = pd.Series(filled).rolling(_WINDOW, center=True).median().to_numpy(copy=True)
    course[:half] = _line(at[:_WINDOW], filled[:_WINDOW])[:half]
    course[-half:] = _line(at[-_WINDOW:], filled[-_WINDOW:])[-half:]
    away = np.abs(filled - course)
    limit = max(SPIKE * max(row_noise(at, filled), step / np.sqrt(12)), 1.5 * step, 1e-12)
    inner = np.flatnonzero(away[half:-half] > limit)
    near, when = (np.lib.stride_tricks.sliding_window_view(each, _WINDOW)[inner] for each in (filled, at))
    slope = np.median(np.diff(near, axis=1) / np.diff(when, axis=1), axis=1)
    straight = np.median(near - slope[:, None] * (when - when[:, [half]]), axis=1)
    away[inner + half] = np.minimum(away[inner + half], np.abs(near[:, half] - straight))
    suspects = np.flatnonzero(away > limit)
    suspects = suspects[
        [away[i] > _MOVES * _moves_beside(at, filled, i, suspects) for i in suspects.tolist()]
    ]
    if driven is not None:
        # The first reading after it, that before, and that in which what it changes shows first.
        near_leaps = np.isin(suspects, np.searchsorted(rows, driven) + np.array([[-1], [0], [1]]))
        # A line through three readings misses the next one by nearly twice their noise.
        bends = [_leads_to(at, filled, i) <= limit for i in suspects.tolist()]
        suspects = suspects[~(near_leaps & np.array(bends, dtype=bool))]
    # A course that really jumps stays away: a spike's neighbours do not.
    near_each = np.sum(np.abs(suspects[:, None] - suspects) <= 2, axis=1)
    lonely = set(suspects[near_each < _LONGEST].tolist())
    for group in _groups(suspects):
        may_be = driven is None or not np.isin(group, np.searchsorted(rows, driven)).any()
        if len(group) == _LONGEST and may_be and _leaps_back(filled, group[0], group[-1]):
            lonely.update(group)
    return rows[np.array(sorted(lonely), dtype=np.int64)]


def leap(times: Array, values: Array, away: Rows) -> float:
    """Largest distance of some readings from the course of all others, in their unit."""
    others = np.setdiff1d(np.flatnonzero(np.isfinite(values)), away)
    course = np.interp(times[away], times[others], values[others])
    return float(np.max(np.abs(values[away] - course)))


def _groups(rows: Rows) -> Iterator[list[int]]:
    """Rows that follow one another."""
    yield from (each.tolist() for each in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1) if each.size)


def _moves_beside(at: Array, values: Array, row: int, suspects: Rows) -> float:
    """By how much readings beside a row, suspects left out, move over the time to its neighbours."""
    beside = np.setdiff1d(
        np.arange(max(row - _WINDOW // 2, 0), min(row + _WINDOW // 2 + 1, at.size)), suspects
    )
    steps, spans = np.diff(values[beside]), np.diff(at[beside])
    near = np.diff(beside) == 1
    rate = float(np.max(np.abs(steps[near] / spans[near]), initial=0.0))
    return rate * float(np.max(np.diff(at[max(row - 1, 0) : row + 2])))


def _leads_to(at: Array, values: Array, row: int) -> float:
    """How far a reading is from the line through the three before it, or after it, whichever is nearer."""
    off = [np.inf]
    for beside in (slice(row - 3, row), slice(row + 1, row + 4)):
        if beside.start >= 0 and beside.stop <= at.size:
            level = np.polyfit(at[beside] - at[row], values[beside], 1)[1]
            off.append(abs(values[row] - level))
    return float(min(off))


def _leaps_back(values: Array, first: int, last: int) -> bool:
    """Whether readings leap to one side, stay, and leap back to where they were."""
    if first == 0 or last == values.size - 1:
        return False
    before, after, level = values[first - 1], values[last + 1], np.median(values[first : last + 1])
    height = level - (before + after) / 2
    up, down = (values[first] - before) / height, (values[last] - after) / height
    return bool(min(up, down) > _AT_ONCE)


def _line(at: Array, values: Array) -> Array:
    """Line through the ends of a run, where no median has neighbours on both sides (Theil and Sen)."""
    a, b = np.triu_indices(values.size, 1)
    slope = float(np.median((values[b] - values[a]) / (at[b] - at[a])))
    return np.asarray(slope * (at - at[0]) + np.median(values - slope * (at - at[0])), dtype=np.float64)

"""Readings that serve as inputs, without most of their noise.

A neighbour's temperature drives an axis as an input does, and its noise with it: in the last cell of a light
link a reading that is 0.1 K off for ten seconds is a disturbance. Between two changes of the duty cycle a
temperature bends slowly, so it is replaced by a straight line fitted to the readings about each row; at a
change, where it has a kink, the lines end.
"""

from __future__ import annotations

import numpy as np

from warmlink.orchestration.arrays import Array

HALF_WIDTH = 60.0
"""s to either side of a row from which its line is fitted."""


def smoothed(time: Array, values: Array, changes: Array) -> Array:
    """Readings as lines fitted about each row give them, shape (n,), for rising times in s.

    Changes of the duty cycle closer together than the lines are wide bend the course too little to end one.
    """
    inner = _lasting(np.concatenate([[time[0]], changes, [time[-1]]]))
    part = np.searchsorted(inner, time, side="right")
    result = np.empty_like(values)
    for i in range(time.size):
        low = np.searchsorted(time, time[i] - HALF_WIDTH)
        high = np.searchsorted(time, time[i] + HALF_WIDTH, side="right")
        window = np.arange(low, high)
        # The row at a change still belongs to the course before it as well.
        near = window[(part[window] == part[i]) | np.isin(time[window], inner)]
        result[i] = _line_at(time[near] - time[i], values[near])
    return result


def over_steps(values: Array) -> Array:
    """Means from each row to the next, shape as given: a row holds until the next, and a reading does not."""
    return np.append((values[1:] + values[:-1]) / 2, values[-1])


def _lasting(times: Array) -> Array:
    """Changes that have at least the lines' half width before and after them."""
    gaps = np.diff(times)
    return times[1:-1][(gaps[:-1] >= HALF_WIDTH) & (gaps[1:] >= HALF_WIDTH)]


def _line_at(distance: Array, values: Array) -> float:
    """Value at distance 0 of the line of least squares."""
    mean, spread = distance.mean(), distance - distance.mean()
    square = float(spread @ spread)
    slope = float(spread @ values) / square if square > 0 else 0.0
    return float(values.mean() - slope * mean)

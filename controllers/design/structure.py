"""What a model can not know of the machine that it stands for: growth that its structure does not have.

A law that was not learnt from a log takes its growth per kelvin of each thermometer, c, from a model. On a
machine of other structure two things are off that no thermometer shows:

- the profile between thermometers: a straight line between them makes the growth c_l instead, and a flange, a
  tool or a rib may lead as far to its other side;
- what grows further in, as a gearbox does, with the innermost thermometer's temperature.

    S = (c_l - c) (c_l - c)^T + (INSIDE e)^2 i i^T

e is the growth per kelvin of an evenly warm link, i is 1 for the innermost thermometer and 0 for the others.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.interface import SENSED
from warmlink.controllers.matrices import upper

Array = NDArray[np.float64]

INSIDE = 0.07
"""Growth per kelvin of what lies further in than the link, as a share of the link's (1 sigma)."""

ALONG = {"base_temperature": 0.0, "middle_temperature": 0.5, "tip_temperature": 1.0}
"""Places along the link."""


def nearest_shares(used: Sequence[int]) -> Array:
    """Share of the link's length to which each thermometer in use is the nearest, 0 for one not on it."""
    places = {k: ALONG[SENSED[i]] for k, i in enumerate(used) if SENSED[i] in ALONG}
    along, shares = (np.arange(1000) + 0.5) / 1000, np.zeros(len(used))
    if places:
        nearest = np.argmin(np.abs(along[:, None] - np.array(list(places.values()))), axis=1)
        shares[list(places)] = np.bincount(nearest, minlength=len(places)) / along.size
    return shares


def structure_spread(coefficients: Array, stds: Sequence[float], per_kelvin: float) -> list[float]:
    """Covariance in (um/K)2 of a model's growth per kelvin of each thermometer, packed.

    Parameters
    ----------
    coefficients : the model's own in m/K, shape (len(SENSED),)
    stds : noise in K of each thermometer, from the motor outwards; 0 for those that the law does not use
    per_kelvin : growth in m/K of an evenly warm link
    """
    spread, used = np.zeros((len(SENSED),) * 2), np.flatnonzero(stds).tolist()
    if used:
        straight, inside = np.zeros((2, len(SENSED)))
        shares = nearest_shares(used)
        straight[used] = shares
        straight[used[-1]] += 1.0 - shares.sum()
        inside[used[0]] = INSIDE
        off = 1e6 * (per_kelvin * straight - coefficients)
        spread = np.outer(off, off) + np.outer(inside, inside) * (1e6 * per_kelvin) ** 2
    return upper(spread).tolist()

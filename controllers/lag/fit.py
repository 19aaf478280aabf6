"""Gain and time constant of the lag law from a run of the cell."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError

Series = NDArray[np.float64]


class FirstOrder(NamedTuple):
    """The law's two parameters, and what they leave of the growth they were fitted to."""

    gain: float
    time_constant: float
    residual_rms: float


def response(time: Series, loss: Series, gain: float, time_constant: float) -> Series:
    """Growth in m by the lag law from none, shape (n,).

    Parameters
    ----------
    time : in s, increasing, shape (n,)
    loss : the motor's losses in W, each held until the next time, shape (n,)
    gain : steady growth a watt, in m/W
    time_constant : in s
    """
    decay = np.exp(-np.diff(time) / time_constant)
    growth = np.zeros(len(time))
    for i, share in enumerate(decay):
        final = gain * loss[i]
        growth[i + 1] = final + (growth[i] - final) * share
    return growth


def first_order(time: Series, loss: Series, elongation: Series) -> FirstOrder:
    """Fit the lag law to a run by least squares.

    Parameters
    ----------
    time, loss : as for `response`
    elongation : growth in m from the start, shape (n,)

    Raises
    ------
    InputError
        The motor made no heat before the last time, so that no gain can be told, or a value is not finite.
    """
    from scipy.optimize import minimize_scalar

    if not all(np.isfinite(each).all() for each in (time, loss, elongation)):
        raise InputError("run: a time, loss or growth is not finite; leave such rows out")
    if not np.any(loss[:-1] > 0):
        raise InputError("loss: 0 W throughout; fit the lag law to a run in which the motor works")

    def best_gain(time_constant: float) -> float:
        unit = response(time, loss, 1.0, time_constant)
        return float(unit @ elongation / (unit @ unit))

    def misfit(exponent: float) -> float:
        time_constant = float(np.exp(exponent))
        error = response(time, loss, best_gain(time_constant), time_constant) - elongation
        return float(error @ error)

    span = time[-1] - time[0]
    found = minimize_scalar(misfit, bounds=(np.log(span * 1e-3), np.log(span * 1e2)), method="bounded")
    time_constant = float(np.exp(found.x))
    return FirstOrder(best_gain(time_constant), time_constant, float(np.sqrt(found.fun / len(time))))

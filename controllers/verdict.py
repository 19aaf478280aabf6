"""When a law may call the cell ready for production."""

from __future__ import annotations

from warmlink.fmus.component.arithmetic import Number, where

SIGMAS = 2.0
"""Standard deviations of the correction's error that must fit into the tolerance, for 95 %."""


def ready(correction_std: Number, tolerance: Number) -> Number:
    """1 where the remaining error is expected within the tolerance, else 0; both in m."""
    return where(SIGMAS * correction_std <= tolerance, 1.0, 0.0)


def error_std(predicted: Number, relative: Number, floor: Number) -> Number:
    """Standard deviation in m of a prediction's error, which has a relative and a constant part.

    Parameters
    ----------
    predicted : predicted elongation in m
    relative : standard deviation of the relative error
    floor : standard deviation in m of the error when the elongation is 0
    """
    return ((relative * predicted) ** 2 + floor**2) ** 0.5

"""When a law may call the cell ready for production."""

from __future__ import annotations

from warmlink.fmus.component import Parameter, Record
from warmlink.fmus.component.arithmetic import Number, truth

SIGMAS = 2.0
"""Standard deviations of the correction's error that must fit into the tolerance, for 95 %."""


def ready(correction_std: Number, tolerance: Number) -> Number:
    """1 where the remaining error is expected within the tolerance, else 0; both in m."""
    return truth(SIGMAS * correction_std <= tolerance)


def error_parameters(least: float) -> tuple[Parameter, ...]:
    """Parameters of `error_std` for a law, `least` being the shipped error in m at no elongation."""
    return (
        Parameter(
            "relative_error", "1", 0.2, "standard deviation of the relative error", minimum=0, nominal=0.1
        ),
        Parameter(
            "least_error",
            "m",
            least,
            "standard deviation of the error when the elongation is 0",
            display="um",
            minimum=0,
            nominal=1e-6,
        ),
    )


def error_std(predicted: Number, p: Record) -> Number:
    """Standard deviation in m of the error of a prediction in m, which has a relative and a constant part."""
    return ((p.relative_error * predicted) ** 2 + p.least_error**2) ** 0.5

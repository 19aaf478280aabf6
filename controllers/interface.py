"""The connectors that every compensating controller has, so that one can replace another."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from warmlink.fmus.component import Component, Input, Output, Parameter, Record, State
from warmlink.fmus.component.arithmetic import Number, absolute, stack, truth, where
from warmlink.fmus.component.quantities import (
    DUTY,
    bus,
    growth_input,
    growth_told,
    sample_time_parameter,
    temperature_input,
    thermometers,
)

_PLACES = {
    "shaft_temperature": "motor's shaft",
    "winding_temperature": "motor's winding",
    "base_temperature": "link at base position",
    "middle_temperature": "link half-way between base and tip position",
    "tip_temperature": "link at tip position",
}

SENSED = tuple(_PLACES)
"""Temperatures that a cell may measure, in the order of the sensors' channels 1 to 5."""

INPUTS = (
    *(
        replace(temperature_input(name, f"measured temperature of the {_PLACES[name]}"), accepts_nan=True)
        for name in SENSED
    ),
    *(replace(each, accepts_nan=True) for each in DUTY[:3]),
    growth_input(
        "measured_drift", "the camera's last reading of elongation minus correction", accepts_nan=True
    ),
    Input(
        "drift_valid", "1", "whether the last reading of the camera is good", type="Boolean", discrete=True
    ),
)


def _flag(name: str, description: str) -> Output:
    return Output(name, "1", f"whether {description}", type="Boolean", discrete=True)


OUTPUTS = (
    growth_told("correction", "distance the tool point is moved back by"),
    growth_told("predicted_elongation", "controller's estimate of the growth"),
    growth_told("correction_std", "standard deviation of the correction's error", nominal=1e-6),
    _flag("ready", "the remaining error is within tolerance"),
    _flag("distrusted", "a signal is left out as not credible"),
    _flag("warning", "a limit on the correction acts or is near"),
)

TERMINALS = (
    thermometers("readings", SENSED),
    bus("duty", "Duty", "speed", "torque", "ambient_temperature"),
    bus("camera", "Camera", "measured_drift", "drift_valid"),
    bus("compensation", "Compensation", *(each.name for each in OUTPUTS)),
)

SAMPLE_TIME = sample_time_parameter("time between two corrections")

HOTTEST = 1e4
"""K, which no thermometer reads: the square of much more is beyond what single precision holds."""

SQUARE_MICROMETRE = 1e-12
"""m^2; covariances of growth per kelvin are in (um/K)^2."""

SIGMAS = 2.0
"""Standard deviations of the correction's error that must fit into the tolerance, for 95 %."""


_LENGTH: dict[str, Any] = {"unit": "m", "display": "um", "nominal": 1e-6}


def length(name: str, start: float, description: str, **more: Any) -> Parameter:
    """A parameter in m that people read in um, or of another unit like it."""
    return Parameter(name, start=start, description=description, **_LENGTH | more)


_TOLERANCE = "largest error of the tool point that production allows"

TOLERANCE = length("tolerance", 5e-6, _TOLERANCE, positive=True, nominal=5e-6, tunable=True)


def compensator(
    name: str,
    description: str,
    law: Any,
    parameters: Sequence[Parameter],
    states: Sequence[State] = (),
    outputs: Sequence[Output] = (),
    **more: Any,
) -> Component:
    """Component of a law, with the connectors of every compensator.

    Parameters
    ----------
    law : module with `outputs`, and `update` and `begin` where it remembers anything
    parameters : besides the tolerance, and the sample time where it samples
    outputs : besides those of every compensator
    more : what else a `Component` may have
    """
    update = getattr(law, "update", None)
    return Component(
        name=name,
        description=description,
        inputs=INPUTS,
        terminals=TERMINALS,
        parameters=(*((SAMPLE_TIME,) if update else ()), TOLERANCE, *parameters),
        states=tuple(states),
        outputs=(*OUTPUTS, *outputs),
        update=update,
        begin=getattr(law, "begin", None),
        observe=law.outputs,
        **more,
    )


def sensed(u: Record) -> Number:
    """Readings in K in the sensors' order, shape (5,); NaN where there is none, or none that can be."""
    readings = stack(*(getattr(u, name) for name in SENSED))
    return where(absolute(readings) <= HOTTEST, readings, math.nan)


def ready(correction_std: Number, tolerance: Number) -> Number:
    """1 where the remaining error is expected within the tolerance, else 0; both in m."""
    return truth(SIGMAS * correction_std <= tolerance)


def law_outputs(
    correction: Number,
    std: Number,
    p: Record,
    predicted: Number | None = None,
    distrusted: Number = 0.0,
    warning: Number = 0.0,
) -> dict[str, Number]:
    """Outputs of a law by name.

    Parameters
    ----------
    correction, std : in m, the latter of the correction's error
    p : parameters, of which the tolerance counts
    predicted : elongation in m; the correction where it is not given
    distrusted : 1 where a signal is left out as not credible, else 0
    warning : 1 where a limit on the correction acts or is near, else 0
    """
    return {
        "correction": correction,
        "predicted_elongation": correction if predicted is None else predicted,
        "correction_std": std,
        "ready": ready(std, p.tolerance),
        "distrusted": distrusted,
        "warning": warning,
    }


def error_parameters(least: float) -> tuple[Parameter, ...]:
    """Parameters of `error_std` for a law, `least` being the shipped error in m at no elongation."""
    relative = "standard deviation of the relative error"
    absolute = "standard deviation of the error when the elongation is 0"
    return (
        Parameter("relative_error", "1", 0.2, relative, minimum=0, nominal=0.1),
        length("least_error", least, absolute, minimum=0),
    )


def error_std(predicted: Number, p: Record) -> Number:
    """Standard deviation in m of the error of a prediction in m, which has a relative and a constant part."""
    return ((p.relative_error * predicted) ** 2 + p.least_error**2) ** 0.5

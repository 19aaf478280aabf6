"""The connectors that every compensating controller has, so that one can replace another."""

from __future__ import annotations

from dataclasses import replace

from warmlink.fmus.component import Input, Output, Parameter, Record
from warmlink.fmus.component.arithmetic import Number, stack
from warmlink.fmus.component.quantities import (
    AMBIENT_TEMPERATURE,
    bus,
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
    Input("speed", "rad/s", "mean absolute speed of the joint", nominal=3),
    Input("torque", "N.m", "rms torque at the joint", nominal=2.5),
    AMBIENT_TEMPERATURE,
    Input(
        "measured_drift",
        "m",
        "the camera's last reading of elongation minus correction",
        display="um",
        nominal=5e-5,
        accepts_nan=True,
    ),
    Input(
        "drift_valid", "1", "whether the last reading of the camera is good", type="Boolean", discrete=True
    ),
)

OUTPUTS = (
    Output("correction", "m", "distance the tool point is moved back by", display="um", nominal=5e-5),
    Output("predicted_elongation", "m", "controller's estimate of the growth", display="um", nominal=5e-5),
    Output("correction_std", "m", "standard deviation of the correction's error", display="um", nominal=1e-6),
    Output("ready", "1", "whether the remaining error is within tolerance", type="Boolean", discrete=True),
    Output("distrusted", "1", "whether a signal is left out as not credible", type="Boolean", discrete=True),
    Output(
        "warning", "1", "whether a limit on the correction acts or is near", type="Boolean", discrete=True
    ),
)

TERMINALS = (
    thermometers("readings", SENSED),
    bus("duty", "Duty", "speed", "torque", "ambient_temperature"),
    bus("camera", "Camera", "measured_drift", "drift_valid"),
    bus("compensation", "Compensation", *(each.name for each in OUTPUTS)),
)

SAMPLE_TIME = sample_time_parameter("time between two corrections")

TOLERANCE = Parameter(
    "tolerance",
    "m",
    5e-6,
    "largest error of the tool point that production allows",
    display="um",
    positive=True,
    nominal=5e-6,
    tunable=True,
)


def sensed(u: Record) -> Number:
    """Readings in K in the sensors' order, shape (5,); NaN where there is none."""
    return stack(*(getattr(u, name) for name in SENSED))

"""The camera as a component."""

from warmlink.fmus import faults
from warmlink.fmus.component import Check, Component, Output, Parameter, State
from warmlink.fmus.component.arithmetic import minimum
from warmlink.fmus.component.quantities import (
    SPEED,
    bus,
    extra,
    growth_input,
    growth_told,
    sample_time_parameter,
    tunable,
)
from warmlink.fmus.drift_camera import equations

_PIXEL_SIZE = "size of a pixel along the link"
_CENTROID_NOISE = "standard deviation of the spot's centroid in pixels"
_MEASURED_DRIFT = "elongation minus correction on the last good picture; NaN under fault 4"

_PARAMETERS = (
    sample_time_parameter("time between two looks at whether a picture is due"),
    Parameter("moving_interval", "s", 30, "time between two pictures while the joint moves", positive=True),
    Parameter("still_interval", "s", 120, "time between two pictures while it is still", positive=True),
    tunable("still_speed", "rad/s", 0.01, "speed up to which the joint counts as still", minimum=0),
    Parameter("pixel_size", "m", 8.6e-6, _PIXEL_SIZE, display="um", positive=True, nominal=1e-5),
    tunable("centroid_noise", "1", 0.0125, _CENTROID_NOISE, minimum=0, nominal=0.01),
    tunable("drift_rate", "m/s", 0, "drift of the camera itself per second", display="um/h", nominal=1e-9),
    tunable("offset", "m", 0, "constant error of the reading", display="um", nominal=1e-6),
    tunable("scale", "1", 1, "measured over true movement of the tool point", positive=True),
    extra("dropout_probability", "1", "probability that a picture is lost", maximum=1, nominal=0.1),
    Parameter("delay", "s", 0, "time from a picture to its reading", minimum=0),
    *faults.parameters("m", "um", 1e-5, 1e-9),
    Parameter("seed", "1", 1, "seed of noise and dropouts", type="Integer", minimum=0),
)

COMPONENT = Component(
    name="DriftCamera",
    description="Camera that sees, a picture at a time, elongation minus correction",
    inputs=(
        growth_input("elongation", "true growth of the link"),
        growth_input("correction", "what the tool point is moved back by"),
        SPEED,
    ),
    parameters=_PARAMETERS,
    states=(
        State("generator", "1", size=2),
        State("count", "1"),
        State("seen", "m", accepts_nan=True),
        State("lost", "1"),
        State("unread", "1"),
        State("measured_drift", "m", accepts_nan=True),
        State("drift_valid", "1"),
        State("age_count", "1"),
    ),
    outputs=(
        growth_told("measured_drift", _MEASURED_DRIFT),
        Output("drift_valid", "1", "whether the last picture is good", type="Boolean", discrete=True),
        Output("age", "s", "time since the last good picture was taken", nominal=30),
    ),
    terminals=(
        bus("camera", "Camera", "measured_drift", "drift_valid"),
        bus("compensation", "Compensation", "correction"),
        bus("duty", "Duty", "speed"),
    ),
    update=equations.update,
    begin=equations.begin,
    observe=equations.outputs,
    checks=(
        Check(
            lambda p: minimum(p.moving_interval, p.still_interval) - p.delay,
            "delay: {delay} s is longer than the time between two pictures; "
            "keep it within moving_interval ({moving_interval} s) and still_interval ({still_interval} s)",
        ),
    ),
)

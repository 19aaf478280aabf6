"""The observer with the camera as a component."""

from __future__ import annotations

from warmlink.controllers.interface import INPUTS, OUTPUTS, TERMINALS
from warmlink.controllers.observer import retained
from warmlink.controllers.observer.component import (
    CHECKS,
    observer_derived,
    observer_parameters,
    observer_states,
)
from warmlink.controllers.observer.law import derive
from warmlink.controllers.observer_drift import law
from warmlink.controllers.start_values import shipped_design, with_values
from warmlink.fmus.component import Component, Parameter, State

_CAMERA = (
    Parameter(
        "camera_std",
        "m",
        3e-7,
        "standard deviation of a camera reading",
        display="um",
        positive=True,
        nominal=1e-6,
    ),
    Parameter("camera_delay", "s", 30, "longest time from a picture to its reading", minimum=0),
    Parameter(
        "camera_timeout",
        "s",
        900,
        "time without a new reading after which the camera is distrusted",
        positive=True,
    ),
    Parameter(
        "camera_return_time",
        "s",
        300,
        "time of small innovations after which the camera is used again",
        positive=True,
    ),
    Parameter(
        "camera_authority",
        "m",
        3e-6,
        "elongation that the camera may add to the one computed from temperatures",
        display="um",
        minimum=0,
        nominal=1e-6,
    ),
    Parameter(
        "camera_relative_authority",
        "1",
        0.15,
        "additional elongation that it may add, as a share of the one computed from temperatures",
        minimum=0,
        nominal=0.1,
    ),
)

COMPONENT = Component(
    name="ObserverDriftCompensator",
    description="Growth by a Kalman filter on motor and link, made offset-free by the camera",
    inputs=INPUTS,
    terminals=TERMINALS,
    parameters=with_values(
        (*observer_parameters(law.DISTURBANCES), *_CAMERA),
        shipped_design("observer") | shipped_design("observer_drift"),
    ),
    states=(
        *observer_states(law.STATES),
        State("camera_last", "m"),
        State("camera_age", "s"),
        State("camera_calm_for", "s"),
        State("camera_out", "1"),
        State("camera_free_for", "s"),
        State("camera_evidence", "1"),
        State("camera_says", "m"),
        State("camera_said", "1"),
    ),
    outputs=(*OUTPUTS, *retained.outputs(law.STATES)),
    derived=observer_derived(law.DISTURBANCES),
    derive=derive,
    update=law.update,
    begin=law.begin,
    observe=law.outputs,
    checks=CHECKS,
)

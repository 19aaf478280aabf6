"""The observer with the camera as a component."""

from warmlink.controllers.interface import length
from warmlink.controllers.observer.component import observer
from warmlink.controllers.observer_drift import law
from warmlink.controllers.start_values import shipped_design
from warmlink.fmus.component import Parameter, State

_CAMERA = (
    length("camera_std", 3e-7, "standard deviation of a camera reading", positive=True),
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
    length(
        "camera_authority",
        3e-6,
        "elongation that the camera may add to the one computed from temperatures",
        minimum=0,
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

COMPONENT = observer(
    "ObserverDriftCompensator",
    "Growth by a Kalman filter on motor and link, made offset-free by the camera",
    law,
    law.DISTURBANCES,
    shipped_design("observer") | shipped_design("observer_drift"),
    _CAMERA,
    tuple(State(f"camera_{name}", unit) for name, unit in law.CAMERA_UNITS._asdict().items()),
)

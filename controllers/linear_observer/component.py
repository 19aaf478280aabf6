"""The linear observer as a component."""

from functools import partial

from warmlink.controllers import fail_safe
from warmlink.controllers.interface import SENSED, compensator, length
from warmlink.controllers.linear_observer import law, model
from warmlink.controllers.matrices import least_pivot, packed_size, symmetric
from warmlink.controllers.observer.model import TOLD_PARAMETERS, TOLD_STATES
from warmlink.controllers.start_values import shipped_design, with_values
from warmlink.fmus.component import Check, Parameter, Record, State
from warmlink.fmus.component.arithmetic import Number

_PACKED = packed_size(model.MODES)
_SPREAD = "covariance of the modes before the first reading, upper triangle's rows"
_NOISE = "covariance per second of what the model does not know, upper triangle's rows"
_OFF = "how far the growth was off in runs that the model was not made from; affects only correction_std"
_RELATIVE = "relative uncertainty of the growth, as of the expansion coefficient; affects only correction_std"

_PARAMETERS = (
    *fail_safe.LIMITS,
    *fail_safe.DOUBT,
    *TOLD_PARAMETERS,
    fail_safe.SENSOR_STD,
    *model.PARAMETERS,
    Parameter("start_spread", "1", 0, _SPREAD, size=_PACKED),
    Parameter("noise", "1/s", 0, _NOISE, size=_PACKED, nominal=1e-6),
    length("model_std", 0, _OFF, minimum=0),
    Parameter("relative_std", "1", 0.015, _RELATIVE, minimum=0, nominal=0.01),
)

_NO_COVARIANCE = (
    "no covariance of the modes, some combination of them has less than none; "
    "design the observer anew with warmlink design --law linear_observer"
)


def _margin(name: str, p: Record) -> Number:
    """By how much a parameter is a covariance; below 0 it is none."""
    return least_pivot(symmetric(getattr(p, name), model.MODES)) + 1e-6


COMPONENT = compensator(
    "LinearObserverCompensator",
    "Growth by a Kalman filter on a linear model of any machine, found from runs of its FMUs",
    law,
    with_values(_PARAMETERS, shipped_design("linear_observer")),
    (
        State("estimate", "1", size=model.MODES),
        State("spread", "1", size=_PACKED),
        *TOLD_STATES,
        *fail_safe.trust_states("K", len(SENSED)),
        *(State(name, "m") for name in ("correction", "elongation")),
        State("distrusted", "1"),
        State("waited", "s"),
    ),
    derived=model.DERIVED,
    derive=model.derive,
    checks=tuple(
        Check(partial(_margin, name), f"{name}: {_NO_COVARIANCE}") for name in ("start_spread", "noise")
    ),
)

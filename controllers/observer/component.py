"""The observer as a component."""

from typing import Any

from warmlink.controllers import fail_safe, smoothing
from warmlink.controllers.interface import SENSED, compensator, length
from warmlink.controllers.matrices import least_pivot, packed_size, symmetric
from warmlink.controllers.observer import law, model, offset, retained, witnesses
from warmlink.controllers.observer.filters import filter_states
from warmlink.controllers.start_values import Values, shipped_design, with_values
from warmlink.fmus.component import Check, Component, Derived, Parameter, State
from warmlink.fmus.component.quantities import temperature_parameter
from warmlink.fmus.component.variables import NOMINAL_TEMPERATURE
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR

_MODES = model.MODES

_DUTY = "how far a log showed growth by duty and surroundings alone to be off (1 sigma)"


def _of_modes(name: str, unit: str, description: str, nominal: float | None = None, **more: Any) -> Parameter:
    """A number for each mode."""
    return Parameter(name, unit, 0, description, nominal=nominal, **{"size": _MODES} | more)


def _parameters(disturbances: int) -> tuple[Parameter, ...]:
    """Parameters of an observer with so many disturbances, the two unknown heats among them."""

    def of_each(name: str, unit: str, start: float, description: str, **more: Any) -> Parameter:
        return Parameter(name, unit, start, description, size=disturbances, **more)

    return (
        *fail_safe.LIMITS,
        *fail_safe.DOUBT,
        *model.TOLD_PARAMETERS,
        *(parameter for parameter in MOTOR.parameters if parameter.name in model.LOSSES),
        Parameter(
            "reference_temperature",
            "K",
            295.15,
            "temperature at which the elongation is 0",
            display="degC",
            nominal=NOMINAL_TEMPERATURE,
            positive=True,
        ),
        Parameter(
            "initial_temperature",
            "K",
            0,
            "temperature of motor and link at a cold start; 0: ambient temperature",
            minimum=0,
            nominal=NOMINAL_TEMPERATURE,
        ),
        Parameter("initial_std", "K", 0, "standard deviation of initial_temperature", minimum=0, nominal=0.1),
        fail_safe.SENSOR_STD,
        length(
            "model_std",
            0,
            "error of the reduced model's elongation, computed by the design; affects only correction_std",
            minimum=0,
            nominal=1e-8,
        ),
        Parameter(
            "relative_std",
            "1",
            0.015,
            "relative uncertainty of the elongation, as of the expansion coefficient; "
            "affects only correction_std, while no camera is followed",
            minimum=0,
            nominal=0.01,
        ),
        length("duty_std", 0, _DUTY, minimum=0),
        Parameter(
            "learnt",
            "1",
            0,
            "1: growth by temperatures was learnt from a log of the machine; affects only correction_std",
            minimum=0,
            maximum=1,
        ),
        Parameter(
            "mean_temperature",
            "K",
            0,
            "temperature at each sensor from which coefficient_spread counts; affects only correction_std",
            size=len(SENSED),
            minimum=0,
            nominal=NOMINAL_TEMPERATURE,
        ),
        Parameter(
            "coefficient_spread",
            "1",
            0,
            "covariance of the growth per kelvin of each sensor in (um/K)2, upper triangle's rows; "
            "affects only correction_std",
            size=packed_size(len(SENSED)),
            nominal=0.01,
        ),
        smoothing.time(smoothing.NONE),
        of_each(
            "disturbance_std",
            "1",
            0,
            "standard deviation of each disturbance: heat in W into shaft, into link, and further ones",
            positive=True,
        ),
        of_each(
            "disturbance_time",
            "s",
            0,
            "correlation time of each disturbance",
            positive=True,
            nominal=1000,
        ),
        of_each(
            "disturbance_start",
            "1",
            1,
            "variance of each disturbance at the start, as a share of its stationary variance",
            minimum=0,
            maximum=1,
        ),
        Parameter(
            "quiet_share",
            "1",
            0.05,
            "share of unknown heat and profile errors that the quiet filter expects",
            minimum=0,
            maximum=1,
        ),
        *_MODEL,
        *offset.PARAMETERS,
        *retained.parameters(model.MODES + disturbances),
    )


_MODEL = (
    temperature_parameter("linearisation_temperature", "temperature from which the modes count"),
    _of_modes("mode_rate", "1/s", "rate of each mode at standstill", 1e-3, maximum=-1e-12),
    _of_modes(
        "convection", "1/rad", "effect of speed times mode on each mode, row after row", 1e-4, size=_MODES**2
    ),
    _of_modes("winding_heat_gain", "K/J", "heat in the winding on each mode", 1e-3),
    _of_modes("shaft_heat_gain", "K/J", "heat in the shaft on each mode", 1e-3),
    _of_modes("link_heat_gain", "K/J", "heat in the link on each mode", 1e-3),
    _of_modes("ambient_gain", "1/s", "ambient temperature on each mode", 1e-3),
    _of_modes("ambient_convection_gain", "1/rad", "speed times ambient temperature on each mode", 1e-4),
    _of_modes(
        "sensor_rows",
        "1",
        "each mode on each sensor's temperature, sensor after sensor",
        size=len(SENSED) * _MODES,
    ),
    _of_modes("elongation_row", "m/K", "each mode on the elongation", 1e-5),
    Parameter(
        "elongation_per_kelvin", "m/K", 0, "elongation when all is warmer by 1 K", positive=True, nominal=1e-5
    ),
    Parameter("link_loss", "W/K", 0, "conductance from the link to still air", minimum=0, nominal=0.1),
    Parameter(
        "link_loss_per_speed", "W.s/(K.rad)", 0, "increase of link_loss per speed", minimum=0, nominal=0.1
    ),
    Parameter(
        "model_share", "1", 0.4, "share of the link's losses by which the model may be wrong", minimum=0
    ),
    Parameter(
        "received_share",
        "1",
        0.02,
        "share of the motor's heat that a wrong model may put into the link",
        minimum=0,
        nominal=0.01,
    ),
    _of_modes("uniform_profile", "1", "modes when all is warmer by 1 K"),
    _of_modes(
        "warm_spread",
        "1",
        "covariance of the modes in a warm cell per squared kelvin at the shaft, upper triangle by rows",
        size=packed_size(_MODES),
    ),
    _of_modes(
        "profile_std",
        "K",
        "standard deviation of each mode that the model does not explain",
        0.01,
        minimum=0,
    ),
)
"""The reduced plant; its values come from `warmlink.controllers.design`."""

_CHECKS = (
    Check(
        lambda p: least_pivot(symmetric(p.warm_spread, _MODES)) + 1e-6,
        "warm_spread: no covariance of the modes, some combination of them has less than none; "
        "design the observer anew with warmlink design --law observer",
    ),
    Check(
        model.stability_margin,
        "convection: errors of the modes grow from sample to sample at the rated speed ({rated_speed} rad/s) "
        "and a sample time of {sample_time} s; design the observer anew with warmlink design --law observer",
    ),
)
"""What must hold across the parameters of an observer."""


def observer(
    name: str,
    description: str,
    law: Any,
    disturbances: int,
    values: Values,
    parameters: tuple[Parameter, ...] = (),
    states: tuple[State, ...] = (),
) -> Component:
    """Component of an observer with so many disturbances.

    Parameters
    ----------
    law : module with `update`, `begin` and `outputs`
    values : the design
    parameters, states : besides those of every observer
    """
    size = model.MODES + disturbances
    return compensator(
        name,
        description,
        law,
        with_values((*_parameters(disturbances), *parameters), values),
        (
            *filter_states(size),
            State("evidence", "1"),
            *model.TOLD_STATES,
            *witnesses.STATES,
            *offset.STATES,
            State("duty_modes", "1", size=_MODES, slow=True),
            State("plausible_heat", "W"),
            *fail_safe.trust_states("K", len(SENSED)),
            *(State(name, "m") for name in ("correction", "elongation")),
            smoothing.STATE,
            State("distrusted", "1"),
            *states,
        ),
        retained.outputs(size),
        derived=(
            Derived("decay", "1", size=_MODES),
            Derived("reach", "s", size=_MODES),
            Derived("fade", "1", size=disturbances),
            *model.GROWTHS,
        ),
        derive=model.derive,
        checks=_CHECKS,
    )


COMPONENT = observer(
    "ObserverCompensator",
    "Growth by a Kalman filter on a reduced model of motor and link",
    law,
    model.HEATS,
    shipped_design("observer"),
)

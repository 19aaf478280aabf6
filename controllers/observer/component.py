"""The observer as a component."""

from __future__ import annotations

from warmlink.controllers import fail_safe
from warmlink.controllers.interface import INPUTS, OUTPUTS, SAMPLE_TIME, SENSED, TERMINALS, TOLERANCE
from warmlink.controllers.matrices import least_pivot, packed_size, symmetric
from warmlink.controllers.observer import law, model, retained, told, witnesses
from warmlink.controllers.observer.filters import filter_states
from warmlink.controllers.start_values import shipped_design, with_values
from warmlink.fmus.component import Check, Component, Derived, Parameter, State
from warmlink.fmus.component.quantities import NOMINAL_TEMPERATURE, temperature_parameter
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR

_MODES = model.MODES


def observer_parameters(disturbances: int) -> tuple[Parameter, ...]:
    """Parameters of an observer with so many disturbances, the two unknown heats among them."""
    return (
        SAMPLE_TIME,
        TOLERANCE,
        *fail_safe.LIMITS,
        *fail_safe.DOUBT,
        *told.PARAMETERS,
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
        Parameter(
            "model_std",
            "m",
            0,
            "error of the reduced model's elongation, computed by the design; affects only correction_std",
            display="um",
            minimum=0,
            nominal=1e-8,
        ),
        Parameter(
            "relative_std",
            "1",
            0,
            "relative uncertainty of the elongation, for example of the expansion coefficient; "
            "affects only correction_std",
            minimum=0,
            nominal=0.01,
        ),
        Parameter(
            "disturbance_std",
            "1",
            0,
            "standard deviation of each disturbance: heat in W into shaft, into link, and further ones",
            size=disturbances,
            positive=True,
        ),
        Parameter(
            "disturbance_time",
            "s",
            0,
            "correlation time of each disturbance",
            size=disturbances,
            positive=True,
            nominal=1000,
        ),
        Parameter(
            "disturbance_start",
            "1",
            1,
            "variance of each disturbance at the start, as a share of its stationary variance",
            size=disturbances,
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
        *retained.parameters(model.MODES + disturbances),
    )


def observer_derived(disturbances: int) -> tuple[Derived, ...]:
    """Values that follow from the parameters alone: decay over a sample, and those of the witnesses."""
    kept = (Derived("decay", "1", size=_MODES), Derived("reach", "s", size=_MODES))
    return (*kept, Derived("fade", "1", size=disturbances), *model.GROWTHS)


def observer_states(size: int) -> tuple[State, ...]:
    """States of an observer whose filters have `size` elements."""
    return (
        *filter_states(size),
        State("evidence", "1"),
        *told.STATES,
        *witnesses.STATES,
        State("duty_modes", "1", size=_MODES),
        State("plausible_heat", "W"),
        *fail_safe.trust_states("K", len(SENSED)),
        State("correction", "m"),
        State("elongation", "m"),
        State("distrusted", "1"),
    )


_MODEL = (
    temperature_parameter("linearisation_temperature", "temperature from which the modes count"),
    Parameter(
        "mode_rate", "1/s", 0, "rate of each mode at standstill", size=_MODES, maximum=-1e-12, nominal=1e-3
    ),
    Parameter(
        "convection",
        "1/rad",
        0,
        "effect of speed times mode on each mode, row after row",
        size=_MODES**2,
        nominal=1e-4,
    ),
    Parameter("winding_heat_gain", "K/J", 0, "heat in the winding on each mode", size=_MODES, nominal=1e-3),
    Parameter("shaft_heat_gain", "K/J", 0, "heat in the shaft on each mode", size=_MODES, nominal=1e-3),
    Parameter("link_heat_gain", "K/J", 0, "heat in the link on each mode", size=_MODES, nominal=1e-3),
    Parameter("ambient_gain", "1/s", 0, "ambient temperature on each mode", size=_MODES, nominal=1e-3),
    Parameter(
        "ambient_convection_gain",
        "1/rad",
        0,
        "speed times ambient temperature on each mode",
        size=_MODES,
        nominal=1e-4,
    ),
    Parameter(
        "sensor_rows",
        "1",
        0,
        "each mode on each sensor's temperature, sensor after sensor",
        size=len(SENSED) * _MODES,
    ),
    Parameter("elongation_row", "m/K", 0, "each mode on the elongation", size=_MODES, nominal=1e-5),
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
    Parameter("uniform_profile", "1", 0, "modes when all is warmer by 1 K", size=_MODES),
    Parameter(
        "warm_spread",
        "1",
        0,
        "covariance of the modes in a warm cell per squared kelvin at the shaft, upper triangle by rows",
        size=packed_size(_MODES),
    ),
    Parameter(
        "profile_std",
        "K",
        0,
        "standard deviation of each mode that the model does not explain",
        size=_MODES,
        minimum=0,
        nominal=0.01,
    ),
)
"""The reduced plant; its values come from `warmlink.controllers.design`."""

CHECKS = (
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

COMPONENT = Component(
    name="ObserverCompensator",
    description="Growth by a Kalman filter on a reduced model of motor and link",
    inputs=INPUTS,
    terminals=TERMINALS,
    parameters=with_values(observer_parameters(model.HEATS), shipped_design("observer")),
    states=observer_states(model.STATES),
    outputs=(*OUTPUTS, *retained.outputs(model.STATES)),
    derived=observer_derived(model.HEATS),
    derive=law.derive,
    update=law.update,
    begin=law.begin,
    observe=law.outputs,
    checks=CHECKS,
)

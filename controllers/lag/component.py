"""The first-order lag as a compensating controller."""

from __future__ import annotations

from warmlink.controllers.fail_safe import LIMITS
from warmlink.controllers.interface import INPUTS, OUTPUTS, SAMPLE_TIME, TERMINALS, TOLERANCE
from warmlink.controllers.lag import law
from warmlink.controllers.verdict import error_parameters
from warmlink.fmus.component import Component, Parameter, State
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR

_LOSSES = tuple(
    parameter
    for parameter in MOTOR.parameters
    if parameter.name
    in {
        "winding_resistance",
        "torque_constant",
        "iron_loss_coefficient",
        "coulomb_friction",
        "viscous_friction",
    }
)

# Gain and time constant: `fit.first_order` on two hours at 100 % duty of the nominal cell; the errors: what
# that leaves over several duty cycles. The tests hold both.
_PARAMETERS = (
    SAMPLE_TIME,
    TOLERANCE,
    *LIMITS,
    Parameter(
        "gain", "m/W", 4.21e-6, "steady growth per watt of loss", display="um/W", nominal=4e-6, tunable=True
    ),
    Parameter("time_constant", "s", 2440, "time constant of the growth", positive=True, tunable=True),
    *_LOSSES,
    *error_parameters(2e-6),
)

COMPONENT = Component(
    name="LagCompensator",
    description="Growth as a first-order lag of the motor's losses",
    inputs=INPUTS,
    terminals=TERMINALS,
    parameters=_PARAMETERS,
    states=(State("elongation", "m"), State("correction", "m")),
    outputs=OUTPUTS,
    update=law.update,
    observe=law.outputs,
)

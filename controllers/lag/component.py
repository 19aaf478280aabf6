"""The first-order lag as a compensating controller."""

from warmlink.controllers.fail_safe import LIMITS
from warmlink.controllers.interface import compensator, error_parameters
from warmlink.controllers.lag import law
from warmlink.fmus.component import Parameter, State
from warmlink.fmus.component.quantities import temperature_parameter, tunable
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR

_LOSSES = {
    "winding_resistance",
    "torque_constant",
    "iron_loss_coefficient",
    "coulomb_friction",
    "viscous_friction",
}

_HEAT = "heat into the motor that the duty does not tell of (1 sigma), a heating pad's for one"
_ROOM = "growth per kelvin of the surroundings above the reference, which is not corrected"

# Gain and time constant: `fit.first_order` on two hours at 100 % duty of the nominal cell; the errors: what
# that leaves over several duty cycles. The tests hold both.
COMPONENT = compensator(
    "LagCompensator",
    "Growth as a first-order lag of the motor's losses",
    law,
    (
        *LIMITS,
        tunable("gain", "m/W", 4.21e-6, "steady growth per watt of loss", display="um/W", nominal=4e-6),
        tunable("time_constant", "s", 2440, "time constant of the growth", positive=True),
        *(parameter for parameter in MOTOR.parameters if parameter.name in _LOSSES),
        *error_parameters(2e-6),
        Parameter("other_heat_std", "W", 20, _HEAT, minimum=0, nominal=10),
        Parameter("growth_per_kelvin", "m/K", 6.88e-6, _ROOM, display="um/K", minimum=0, nominal=1e-6),
        temperature_parameter("reference_temperature", "surroundings in which nothing grows"),
    ),
    (
        State("loss", "W"),
        *(State(name, "m") for name in ("elongation", "correction", "unknown")),
        State("ambient", "K", start="reference_temperature"),
        State("distrusted", "1"),
    ),
)

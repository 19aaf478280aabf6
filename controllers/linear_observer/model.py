"""The linear model that a machine was found to be, and what drives it.

    dz/dt = A z + B f,    T_j = c_j z + T_ref_j,    growth = e z + g_ref

f are the features: heat as a machine makes it of speed w and torque t, the rise of the surroundings, and the
cooling that motion adds at each thermometer,

    1, |w|, w^2, |w t|, t^2, T_a - T_0, |w| (T_j - T_a)

A sample takes them as constant: z' = Phi z + Psi B f, with Phi = exp(A h) and Psi its integral over a sample,
by a Taylor series over a small part of h that is doubled again and again. C. Moler and C. Van Loan, "Nineteen
dubious ways to compute the exponential of a matrix", SIAM Review 45 (2003) 3-49, method 3.
"""

from warmlink.controllers.interface import SENSED
from warmlink.controllers.matrices import diagonal, dot, matrix
from warmlink.controllers.observer.model import BelievedDuty
from warmlink.fmus.calls import as_c_function
from warmlink.fmus.component import Derived, Parameter, Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute, stack
from warmlink.fmus.component.quantities import temperature_parameter

MODES = 8
"""States of the model: a thermal machine that is driven by a few heats needs no more."""

SENSORS = len(SENSED)

FEATURES = 6 + SENSORS

_TERMS, _DOUBLINGS = 6, 9
"""Terms of the series and doublings: 1e-12 for modes that fade within a tenth of a sample."""


def features(speed: Number, torque: Number, around: Number, above: list[Number]) -> tuple[Number, ...]:
    """What drives the model, in SI.

    Parameters
    ----------
    speed, torque : in rad/s and N.m, or any other unit that a machine's own signals have
    around : rise of the surroundings in K from where the model counts
    above : temperature at each thermometer in K above the surroundings; 0 for one that is not used
    """
    fast = absolute(speed)
    heats = 1.0 + 0.0 * fast, fast, speed**2, absolute(speed * torque), torque**2
    return (*heats, around, *(fast * each for each in above))


def sensor_row(sensor: int, p: Record) -> Number:
    """Derivative of a sensor's temperature by the modes, shape (8,)."""
    return p.sensor_rows[sensor * MODES : (sensor + 1) * MODES]


def driven(duty: BelievedDuty, modes: Number, p: Record) -> Number:
    """B f in 1/s, shape (8,)."""
    above = [
        p.cooled[i] * (dot(sensor_row(i, p), modes) + p.sensor_reference[i] - duty.ambient_temperature)
        for i in range(SENSORS)
    ]
    around = duty.ambient_temperature - p.reference_temperature
    return matrix(p.gains, MODES) @ stack(*features(duty.speed, duty.torque, around, above))


def later(modes: Number, duty: BelievedDuty, p: Record) -> Number:
    """Modes a sample later."""
    return matrix(p.carried, MODES) @ modes + matrix(p.reach, MODES) @ driven(duty, modes, p)


def growth(modes: Number, p: Record) -> Number:
    """Growth in m."""
    return dot(p.growth_row, modes) + p.growth_reference


def derive(p: Record) -> Values:
    """Transition over a sample, and its integral."""
    part = p.sample_time / 2.0**_DOUBLINGS
    state, unit = matrix(p.dynamics, MODES) * part, diagonal(stack(*[1.0] * MODES))
    reach = unit
    for k in range(_TERMS, 1, -1):
        reach = unit + (state @ reach) / k
    transition, reach = unit + state @ reach, part * reach
    for _ in range(_DOUBLINGS):
        transition, reach = _doubled(transition, reach)
    return {"carried": _flat(transition), "reach": _flat(reach)}


@as_c_function
def _doubled(transition: Number, reach: Number) -> tuple[Number, Number]:
    return transition @ transition, reach + transition @ reach


def _flat(square: Number) -> Number:
    return stack(*[square[i, j] for i in range(MODES) for j in range(MODES)])


PARAMETERS = (
    Parameter("dynamics", "1/s", 0, "A: each mode on each mode, row after row", size=MODES**2, nominal=1e-3),
    Parameter(
        "gains", "1", 0, "B: each feature on each mode, row after row", size=MODES * FEATURES, nominal=1e-3
    ),
    Parameter(
        "cooled",
        "1",
        0,
        "1: a thermometer at which the model knows how motion cools",
        size=SENSORS,
        minimum=0,
    ),
    Parameter(
        "sensor_rows",
        "1",
        0,
        "each mode on each sensor's temperature, sensor after sensor",
        size=SENSORS * MODES,
    ),
    Parameter(
        "sensor_reference",
        "K",
        295.15,
        "temperature at each sensor while all modes are 0",
        size=SENSORS,
        nominal=300,
        positive=True,
    ),
    Parameter("growth_row", "m", 0, "each mode on the growth", size=MODES, nominal=1e-5),
    Parameter("growth_reference", "m", 0, "growth while all modes are 0", display="um", nominal=1e-6),
    Parameter("even_profile", "1/K", 0, "modes where all is as warm as the surroundings, by 1 K", size=MODES),
    temperature_parameter("reference_temperature", "temperature from which that of the surroundings counts"),
)

DERIVED = (Derived("carried", "1", size=MODES**2), Derived("reach", "s", size=MODES**2))

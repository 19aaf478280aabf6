"""The reduced model of motor and link that the observers carry.

    dz/dt = diag(mode_rate) z + |speed| M z + B_w P_w + B_s P_s + (B_a + |speed| B_av) (T_a - T_0)
    T_j   = c_j z + T_0,        elongation = e z - e_1 (T_ref - T_0)

P_w and P_s are the motor's losses by its own equations. Duty and surroundings are believed within ratings,
bands and rates; beyond them a signal is no news.
"""

from typing import NamedTuple

from warmlink.controllers.interface import SENSED
from warmlink.controllers.matrices import diagonal, dot, matrix, outer, symmetric
from warmlink.fmus.calls import as_c_function
from warmlink.fmus.component import Derived, Parameter, Record, State, Values
from warmlink.fmus.component.arithmetic import (
    Number,
    absolute,
    accumulated,
    clip,
    exp,
    maximum,
    minimum,
    placed,
    stack,
    truth,
    where,
)
from warmlink.fmus.motor_heat_source.equations import copper_loss, friction_loss, idle_loss, iron_loss

MODES = 7
"""Modes of motor and link that the filter carries."""

HEATS = 2
"""Unknown heats: into the shaft, into the link."""

STATES = MODES + HEATS

SENSORS = len(SENSED)

LOSSES = (
    "winding_resistance",
    "winding_temperature_coefficient",
    "torque_constant",
    "iron_loss_coefficient",
    "coulomb_friction",
    "viscous_friction",
    "friction_factor",
    "friction_temperature_coefficient",
    "viscosity_temperature_coefficient",
    "standby_power",
    "moving_power",
)
"""Parameters of the motor that its loss equations ask for."""

WINDING = SENSED.index("winding_temperature")
BASE = SENSED.index("base_temperature")
_SHAFT = SENSED.index("shaft_temperature")


GROWTHS = (
    Derived("growth_by_all", "m/K", size=SENSORS),
    Derived("growth_by_one", "m/K", size=SENSORS),
    Derived("contrast", "1", size=SENSORS),
    Derived("contrast_row", "1", size=MODES),
    Derived("flattest_rise", "1", size=SENSORS),
)
"""Growth in m for a rise of each sensor: where all sensors in use are there, and by each of them alone. The
innermost of them beside the outermost, as the growth follows either, by the sensors and by the modes.
Rise of each beside the others' where heat in the shaft has lasted, as flat as a wrong model leaves it."""

FLATTER = 0.36
"""Power of the model's own rise: 2/3 is a link that loses a fifth less and conducts a fifth more; a link
that cools is flatter still."""


class TrustedDuty(NamedTuple):
    """What the motor's loss equations ask of the inputs."""

    speed: Number
    torque: Number
    current: Number


def decay_and_reach(p: Record, step: Number) -> tuple[Number, Number]:
    """What is left of each mode after a step, and what a rate held over the step adds to it."""
    decay = exp(p.mode_rate * step)
    return decay, (decay - 1.0) / p.mode_rate


def stability_margin(p: Record) -> Number:
    """By how much a sample shrinks the slowest error of a mode, at standstill and at the rated speed."""
    decay, reach = decay_and_reach(p, p.sample_time)
    gained = reach * p.rated_speed * diagonal(matrix(p.convection, MODES))
    least: Number = 1.0
    for i in range(MODES):
        least = minimum(least, 1.0 - maximum(absolute(decay[i] + gained[i]), decay[i]))
    return least


@as_c_function
def by_duty(modes: Number, u: Record, p: Record) -> Number:
    """Modes a sample later by duty signals and surroundings alone."""
    return accumulated(modes, (p.decay - 1.0) * modes + p.reach * known_heat(modes, u, p))


def known_heat(modes: Number, u: Record, p: Record) -> Number:
    """What losses, surroundings and convection do to the modes, in K/s, shape (7,)."""
    winding_loss, shaft_loss = losses(modes, u, p)
    speed = absolute(u.speed)
    ambient = u.ambient_temperature - p.linearisation_temperature
    return (
        p.winding_heat_gain * winding_loss
        + p.shaft_heat_gain * shaft_loss
        + (p.ambient_gain + speed * p.ambient_convection_gain) * ambient
        + speed * (matrix(p.convection, MODES) @ modes)
    )


def losses(modes: Number, u: Record, p: Record) -> tuple[Number, Number]:
    """Losses of the motor in W, in the winding and in the shaft, by its own equations."""
    duty = TrustedDuty(u.speed, u.torque, 0.0)
    winding = copper_loss(temperature(WINDING, modes, p), duty, p) + iron_loss(duty, p)
    return winding, friction_loss(temperature(_SHAFT, modes, p), duty, p) + idle_loss(duty, p)


def temperature(sensor: int, modes: Number, p: Record) -> Number:
    """Temperature in K at a sensor."""
    return dot(sensor_row(sensor, p), modes) + p.linearisation_temperature


def temperatures(modes: Number, p: Record) -> Number:
    """Temperatures in K at all sensors, shape (5,)."""
    return matrix(p.sensor_rows, SENSORS) @ modes + p.linearisation_temperature


def sensor_row(sensor: int, p: Record) -> Number:
    """Derivative of a sensor's temperature by the modes, shape (7,)."""
    return p.sensor_rows[sensor * MODES : (sensor + 1) * MODES]


def elongation(mean: Number, p: Record) -> Number:
    """Elongation in m that the modes make."""
    shift = p.elongation_per_kelvin * (p.reference_temperature - p.linearisation_temperature)
    return dot(p.elongation_row, mean[:MODES]) - shift


def derive(p: Record) -> Values:
    """Values that follow from the parameters alone: decay over a sample, and the growths by the sensors."""
    decay, reach = decay_and_reach(p, p.sample_time)
    return {"decay": decay, "reach": reach, "fade": exp(-p.sample_time / p.disturbance_time), **_growths(p)}


def _growths(p: Record) -> Values:
    """Growth in m for a kelvin at the sensors: regression over links left warm and links warm throughout.

    G = E_T (S_TT + R)^-1, with the covariances of such links, one sensor's row after the other
    """
    spread = 100.0 * (symmetric(p.warm_spread, MODES) + outer(p.uniform_profile, p.uniform_profile))
    rows, used = matrix(p.sensor_rows, SENSORS), truth(p.sensor_std > 0)
    seen = rows @ spread
    alone = used * (seen @ p.elongation_row) / maximum(diagonal(seen @ rows.T), 1e-9)
    # The gain of all at once, as the filter that takes one after the other makes it: mean = K y.
    gain = outer(p.uniform_profile, 0.0 * used)
    for i in range(SENSORS):
        row = sensor_row(i, p)
        across = spread @ row
        k = across * (used[i] / (dot(row, across) + p.sensor_std[i] ** 2 + 1e-9))
        gain = gain + outer(k, placed(1.0, i, SENSORS) - gain.T @ row)
        spread = spread - outer(k, across)
    by_all = gain.T @ p.elongation_row
    contrast = _contrast(by_all / p.elongation_per_kelvin, p)
    steady = rows @ (p.shaft_heat_gain / -p.mode_rate)
    return {
        "growth_by_all": by_all,
        "growth_by_one": alone,
        "contrast": contrast,
        "contrast_row": rows.T @ contrast,
        "flattest_rise": maximum(steady, 1e-9) ** FLATTER,
    }


def _contrast(by_all: Number, p: Record) -> Number:
    """The innermost sensor in use less the outermost, as the growth follows the one that it follows more."""
    order = (0, *range(2, SENSORS))  # the winding has a heat source of its own
    used = [truth(p.sensor_std[i] > 0) for i in range(SENSORS)]
    weight: Number = 0.0
    found: list[Number] = [0.0] * SENSORS
    for sign, places in ((1.0, order), (-1.0, order[::-1])):
        free: Number = 1.0
        for i in places:
            found[i] = found[i] + sign * free * used[i]
            weight = maximum(weight, free * used[i] * by_all[i])
            free = free * (1.0 - used[i])
    return CONTRAST * weight * stack(*found)


_SPEED = "speed of the joint beyond which the signal is not believed"
_TORQUE = "rms torque beyond which the signal is not believed"
_RATE = "fastest change of the surroundings' temperature that is believed"

TOLD_PARAMETERS = (
    Parameter("rated_speed", "rad/s", 8, _SPEED, positive=True),
    Parameter("rated_torque", "N.m", 8, _TORQUE, positive=True),
    Parameter("ambient_rate_limit", "K/s", 10 / 3600, _RATE, display="K/h", positive=True, nominal=1e-3),
)

TOLD_STATES = tuple(
    State(f"believed_{name}", unit)
    for name, unit in (("speed", "rad/s"), ("torque", "N.m"), ("ambient", "K"))
)

CONTRAST = 2.0
"""How much what one thermometer has alone counts beside what all have in common."""

COLDEST, WARMEST = 223.15, 343.15
"""K between which the surroundings' temperature is believed."""

AMBIENT_DOUBT = 1.0
"""K between given and believed temperature of the surroundings from which on it is doubted."""


class BelievedDuty(NamedTuple):
    """Duty and surroundings as they are believed; the names are those of the inputs."""

    speed: Number
    torque: Number
    ambient_temperature: Number


def believed_states(duty: BelievedDuty) -> dict[str, Number]:
    """What is believed under the names of a law's states."""
    return {
        "believed_speed": duty.speed,
        "believed_torque": duty.torque,
        "believed_ambient": duty.ambient_temperature,
    }


def believed(x: Record, u: Record, p: Record, step: Number) -> tuple[BelievedDuty, BelievedDuty, Number]:
    """The trusted duty, the duty with implausible values set to zero, and 1 if any of it is doubted.

    A speed or torque beyond its rating is no news: the filter goes on with the last one that was, and the
    duty as a witness with none, which is the least that can have been.
    """
    speed_well = truth(absolute(u.speed) <= p.rated_speed)
    torque_well = truth(absolute(u.torque) <= p.rated_torque)
    speed = where(speed_well > 0, u.speed, x.believed_speed)
    torque = where(torque_well > 0, u.torque, x.believed_torque)
    well = ambient_well(u)
    given = where(well > 0, u.ambient_temperature, x.believed_ambient)
    reach = p.ambient_rate_limit * step
    ambient = x.believed_ambient + clip(given - x.believed_ambient, -reach, reach)
    off = where(absolute(given - ambient) > AMBIENT_DOUBT, 1.0, 1.0 - well)
    doubted = maximum(1.0 - speed_well * torque_well, off)
    idle = BelievedDuty(where(speed_well > 0, speed, 0.0), where(torque_well > 0, torque, 0.0), ambient)
    return BelievedDuty(speed, torque, ambient), idle, doubted


def believed_at_start(u: Record, p: Record) -> BelievedDuty:
    """What is believed at the start."""
    return BelievedDuty(
        where(absolute(u.speed) <= p.rated_speed, u.speed, 0.0),
        where(absolute(u.torque) <= p.rated_torque, u.torque, 0.0),
        where(ambient_well(u) > 0, u.ambient_temperature, p.reference_temperature),
    )


def ambient_well(u: Record) -> Number:
    """1 where the surroundings' temperature can be one, else 0."""
    above = truth(u.ambient_temperature >= COLDEST)
    return where(u.ambient_temperature <= WARMEST, above, 0.0)

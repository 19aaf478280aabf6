"""What is believed of duty and surroundings: ratings, bands and rates beyond which a signal is no news."""

from __future__ import annotations

from typing import NamedTuple

from warmlink.fmus.component import Parameter, Record, State
from warmlink.fmus.component.arithmetic import Number, absolute, clip, maximum, truth, where

PARAMETERS = (
    Parameter(
        "rated_speed", "rad/s", 8, "speed of the joint beyond which the signal is not believed", positive=True
    ),
    Parameter("rated_torque", "N.m", 8, "rms torque beyond which the signal is not believed", positive=True),
    Parameter(
        "ambient_rate_limit",
        "K/s",
        10 / 3600,
        "fastest change of the surroundings' temperature that is believed",
        display="K/h",
        positive=True,
        nominal=1e-3,
    ),
)

STATES = tuple(
    State(f"believed_{name}", unit)
    for name, unit in (("speed", "rad/s"), ("torque", "N.m"), ("ambient", "K"))
)

COLDEST, WARMEST = 223.15, 343.15
"""K between which the surroundings' temperature is believed."""

AMBIENT_DOUBT = 1.0
"""K between given and believed temperature of the surroundings from which on it is doubted."""


class Told(NamedTuple):
    """Duty and surroundings as they are believed; the names are those of the inputs."""

    speed: Number
    torque: Number
    ambient_temperature: Number


def named(told: Told) -> dict[str, Number]:
    """What is believed under the names of a law's states."""
    return {
        "believed_speed": told.speed,
        "believed_torque": told.torque,
        "believed_ambient": told.ambient_temperature,
    }


def believed(x: Record, u: Record, p: Record, step: Number) -> tuple[Told, Told, Number]:
    """What to go by, the same with no duty where it tells nothing, and 1 where any of it is doubted.

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
    idle = Told(where(speed_well > 0, speed, 0.0), where(torque_well > 0, torque, 0.0), ambient)
    return Told(speed, torque, ambient), idle, doubted


def first_believed(u: Record, p: Record) -> Told:
    """What is believed at the start."""
    return Told(
        where(absolute(u.speed) <= p.rated_speed, u.speed, 0.0),
        where(absolute(u.torque) <= p.rated_torque, u.torque, 0.0),
        where(ambient_well(u) > 0, u.ambient_temperature, p.reference_temperature),
    )


def ambient_well(u: Record) -> Number:
    """1 where the surroundings' temperature can be one, else 0."""
    above = truth(u.ambient_temperature >= COLDEST)
    return where(u.ambient_temperature <= WARMEST, above, 0.0)

"""Growth as a first-order lag of the motor's losses.

time_constant dE/dt = gain P - E,   P = R I^2 + c_fe w^2 + (t_c + b_v |w|) |w|,   I = torque / k_t

The law sees no thermometer. So its doubt counts in full what only thermometers would show: heat that the duty
does not tell of, as much as may have come since the start, and growth by the surroundings.
"""

from warmlink.controllers.fail_safe import limited, reported
from warmlink.controllers.interface import error_std
from warmlink.controllers.observer.model import ambient_well
from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute, exp, truth, where

PLAUSIBLE = 10.0
"""Largest corrections that a loss may make in the end; duty signals that make more, or are NaN, are none."""


def begin(u: Record, p: Record) -> Values:
    """States at the start: no growth, and the surroundings as they are told, if they can be so."""
    none = dict.fromkeys(("loss", "elongation", "correction", "unknown"), 0.0)
    well = ambient_well(u)
    ambient = where(well > 0, u.ambient_temperature, p.reference_temperature)
    return {**none, "ambient": ambient, "distrusted": 1.0 - well}


def update(x: Record, u: Record, p: Record, time: Number, step: Number) -> Values:
    """States after a sample; exact for losses held over it, and while they are unknown for the last ones."""
    told = loss(u, p)
    well = truth(absolute(p.gain * told) <= PLAUSIBLE * p.correction_limit)
    held = where(well > 0, told, x.loss)
    final = p.gain * held
    kept = exp(-step / p.time_constant)
    elongation = final + (x.elongation - final) * kept
    most = p.gain * p.other_heat_std
    ambient_told = ambient_well(u)
    return {
        "loss": held,
        "elongation": elongation,
        "correction": limited(x.correction, elongation, p, step),
        "unknown": most + (x.unknown - most) * kept,
        "ambient": where(ambient_told > 0, u.ambient_temperature, x.ambient),
        "distrusted": 1.0 - well * ambient_told,
    }


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Correction and its uncertainty in m."""
    return reported(x, doubt(x, p), p, x.distrusted)


def doubt(x: Record, p: Record) -> Number:
    """Standard deviation in m of the growth's error: of the fit, and of what no thermometer shows."""
    by_room = p.growth_per_kelvin * (x.ambient - p.reference_temperature)
    return (error_std(x.elongation, p) ** 2 + x.unknown**2 + by_room**2) ** 0.5


def loss(u: Record, p: Record) -> Number:
    """Heat in W that the motor makes at its nominal temperature."""
    speed = absolute(u.speed)
    copper = p.winding_resistance * (u.torque / p.torque_constant) ** 2
    iron = p.iron_loss_coefficient * speed**2
    return copper + iron + (p.coulomb_friction + p.viscous_friction * speed) * speed

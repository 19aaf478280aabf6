"""Growth as a first-order lag of the motor's losses.

time_constant dE/dt = gain P - E,   P = R I^2 + c_fe w^2 + (t_c + b_v |w|) |w|,   I = torque / k_t
"""

from warmlink.controllers.fail_safe import limited, reported
from warmlink.controllers.interface import error_std
from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute, exp, truth, where

PLAUSIBLE = 10.0
"""Largest corrections that a loss may make in the end; duty signals that make more, or are NaN, are none."""


def update(x: Record, u: Record, p: Record, time: Number, step: Number) -> Values:
    """States after a sample; exact for losses held over it, and while they are unknown for the last ones."""
    told = loss(u, p)
    well = truth(absolute(p.gain * told) <= PLAUSIBLE * p.correction_limit)
    held = where(well > 0, told, x.loss)
    final = p.gain * held
    elongation = final + (x.elongation - final) * exp(-step / p.time_constant)
    return {
        "loss": held,
        "elongation": elongation,
        "correction": limited(x.correction, elongation, p, step),
        "distrusted": 1.0 - well,
    }


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Correction and its uncertainty in m."""
    return reported(x, error_std(x.elongation, p), p, x.distrusted)


def loss(u: Record, p: Record) -> Number:
    """Heat in W that the motor makes at its nominal temperature."""
    speed = absolute(u.speed)
    copper = p.winding_resistance * (u.torque / p.torque_constant) ** 2
    iron = p.iron_loss_coefficient * speed**2
    return copper + iron + (p.coulomb_friction + p.viscous_friction * speed) * speed

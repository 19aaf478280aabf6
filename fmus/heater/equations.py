"""A heater of some heat capacity behind a contact resistance.

    C dT_h/dt = on power - (T_h - T_b) / R

and, where C = 0, on power enters the link as it is and T_h = T_b + R on power.
"""

from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, where

LEAST_HEAT_CAPACITY = 1e-6
"""J/K; rates of a much smaller one exceed all numbers."""

LEAST_RESISTANCE = 1e-4
"""K/W; through a much smaller one the flow would be the rounding of the temperatures."""


def rates(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Time derivatives of the states: temperature in K/s, heat delivered in W."""
    given = heat_flow(x, u, p)
    stored = (u.on * p.power - given) / where(p.heat_capacity > 0, p.heat_capacity, 1.0)
    return {"temperature": stored, "heat_delivered": given}


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Heat flow in W, temperature in K, heat in J."""
    without_capacity = u.link_base_temperature + p.contact_resistance * (u.on * p.power)
    return {
        "heat_flow": heat_flow(x, u, p),
        "heater_temperature": where(p.heat_capacity > 0, x.temperature, without_capacity),
        "heat_delivered": x.heat_delivered,
    }


def heat_flow(x: Record, u: Record, p: Record) -> Number:
    """Heat flow in W into the link: all that is given, or what crosses the contact."""
    resistance = where(p.heat_capacity > 0, p.contact_resistance, 1.0)
    crossing = (x.temperature - u.link_base_temperature) / resistance
    return where(p.heat_capacity > 0, crossing, u.on * p.power)

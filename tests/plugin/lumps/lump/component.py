"""A lump of metal that cools: C dT/dt = Q - G (T - T_ambient)."""

from __future__ import annotations

from collections.abc import Mapping

from warmlink.fmus.component import Component, Input, Parameter, Record, State
from warmlink.fmus.component.arithmetic import Number
from warmlink.fmus.component.quantities import temperature_input, temperature_output, temperature_parameter


def rates(x: Record, u: Record, p: Record, time: Number) -> Mapping[str, Number]:
    """Time derivative of the temperature in K/s."""
    lost = p.conductance * (x.temperature - u.ambient_temperature)
    return {"temperature": (u.heat_flow - lost) / p.heat_capacity}


def outputs(x: Record, u: Record, p: Record, time: Number) -> Mapping[str, Number]:
    """Temperature in K."""
    return {"lump_temperature": x.temperature}


COMPONENT = Component(
    name="Lump",
    description="Lump of metal that cools",
    inputs=(
        Input("heat_flow", "W", "heat flow into the lump", nominal=5),
        temperature_input("ambient_temperature", "temperature of the surroundings"),
    ),
    parameters=(
        Parameter("heat_capacity", "J/K", 200, "heat capacity of the lump", positive=True),
        Parameter("conductance", "W/K", 2, "conductance to the surroundings", minimum=0, nominal=1),
        temperature_parameter("initial_temperature", "temperature of the lump at the start"),
    ),
    states=(State("temperature", "K", start="initial_temperature"),),
    outputs=(temperature_output("lump_temperature", "temperature of the lump"),),
    rates=rates,
    observe=outputs,
)

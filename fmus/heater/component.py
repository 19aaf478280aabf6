"""The heater as a component."""

from warmlink.fmus.component import Check, Component, Input, Output, Parameter, State
from warmlink.fmus.component.arithmetic import where
from warmlink.fmus.component.quantities import (
    heat_port,
    temperature_input,
    temperature_output,
    temperature_parameter,
    tunable,
)
from warmlink.fmus.heater import equations

_CONTACT_RESISTANCE = "thermal resistance from heater to link; above 0 if there is a heat capacity"

COMPONENT = Component(
    name="Heater",
    description="Electric heater on a link; with no heat capacity it passes its power through",
    inputs=(
        Input("on", "1", "share of the power that is on", minimum=0, maximum=1, nominal=1),
        temperature_input("link_base_temperature", "temperature of the link at base position"),
    ),
    parameters=(
        tunable("power", "W", 6, "power of the heater", minimum=0),
        Parameter("heat_capacity", "J/K", 0, "heat capacity of the heater", minimum=0, nominal=10),
        Parameter("contact_resistance", "K/W", 0, _CONTACT_RESISTANCE, minimum=0, nominal=0.1),
        temperature_parameter("initial_temperature", "temperature of the heater at the start"),
    ),
    states=(State("temperature", "K", start="initial_temperature"), State("heat_delivered", "J")),
    outputs=(
        Output("heat_flow", "W", "heat flow into the link", nominal=5),
        temperature_output("heater_temperature", "temperature of the heater"),
        Output("heat_delivered", "J", "heat delivered to the link since the start", nominal=1e4),
    ),
    terminals=(heat_port("link", "heat_flow", "link_base_temperature"),),
    rates=equations.rates,
    observe=equations.outputs,
    checks=(
        Check(
            lambda p: where(p.heat_capacity > 0, p.heat_capacity - equations.LEAST_HEAT_CAPACITY, 0.0),
            "heat_capacity: {heat_capacity} J/K is too small to compute with; give 0 for none or at least "
            f"{equations.LEAST_HEAT_CAPACITY:g} J/K",
        ),
        Check(
            lambda p: where(p.heat_capacity > 0, p.contact_resistance - equations.LEAST_RESISTANCE, 0.0),
            "contact_resistance: {contact_resistance} K/W with a heat_capacity of {heat_capacity} J/K; "
            f"give a resistance of at least {equations.LEAST_RESISTANCE:g} K/W, or no heat capacity",
        ),
    ),
)

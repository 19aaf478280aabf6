"""The heat path as a component."""

from warmlink.fmus.component import Component, Input, Output, Parameter
from warmlink.fmus.component.quantities import temperature_input
from warmlink.fmus.heat_path import equations

COMPONENT = Component(
    name="HeatPath",
    description="Heat between two places, or from a source, added to what a model has already",
    inputs=(
        temperature_input("from_temperature", "temperature of the place that gives heat"),
        temperature_input("to_temperature", "temperature of the place that receives it"),
        Input("from_heat_flow", "W", "heat flow into the giving place without this path", nominal=5),
        Input("to_heat_flow", "W", "heat flow into the receiving place without this path", nominal=5),
        Input("speed", "rad/s", "speed that makes heat", nominal=3),
    ),
    parameters=(
        Parameter("conductance", "W/K", 0, "thermal conductance between the places", minimum=0, nominal=1),
        Parameter("heat", "W", 0, "constant heat into the receiving place", nominal=5),
        Parameter("heat_rate", "W/s", 0, "growth of that heat with time", nominal=1e-3),
        Parameter("heat_per_speed", "W.s/rad", 0, "heat for each rad/s of speed", nominal=1),
    ),
    outputs=(
        Output("total_from_heat_flow", "W", "heat flow into the giving place with this path", nominal=5),
        Output("total_to_heat_flow", "W", "heat flow into the receiving place with this path", nominal=5),
    ),
    observe=equations.outputs,
)

"""The thermal link as a component."""

from collections.abc import Callable
from functools import cache, partial

from warmlink.fmus.component import Check, Component, Derived, Input, Local, Output, Parameter, Record, State
from warmlink.fmus.component.arithmetic import Number
from warmlink.fmus.component.quantities import (
    AMBIENT_ERROR,
    AMBIENT_TEMPERATURE,
    SPEED,
    bus,
    extra,
    growth_output,
    heat_port,
    length_parameter,
    per_kelvin,
    temperature_input,
    temperature_output,
    temperature_parameter,
    tunable,
)
from warmlink.fmus.thermal_link import equations

CELLS = 40
SENSORS = equations.SENSORS

_INPUTS = (
    Input("heat_flow", "W", "heat flow into the link at base position", nominal=5),
    Input("tip_heat_flow", "W", "heat flow into the link at tip position", nominal=5),
    temperature_input("tip_sink_temperature", "temperature behind the tip conductance"),
    AMBIENT_TEMPERATURE,
    SPEED,
)

# Descriptions that are too long for the lines below.
_CROSS_SECTION = "cross-section; 0: width times thickness"
_PERIMETER = "perimeter of the cross-section; 0: that of the rectangle"
_EXPANSION_COEFFICIENT = "linear coefficient of thermal expansion at 295.15 K"
_EXPANSION = "relative change of the expansion coefficient per kelvin above 295.15 K"
_SPECIFIC_HEAT = "relative change of heat capacity, with what the link carries, per kelvin above 295.15 K"
_CONVECTION_PER_SPEED = "increase of the convection coefficient per m/s of the link's mean speed"
_MIXING = "0: convection in still air and by motion add up; 1: as the cube root of the sum of their cubes"
_RISE = "power of the rise over ambient with which the coefficient of still air grows, about a rise of 10 K"
_HUB_HEAT_CAPACITY = "heat capacity of what sits at base position"
_INITIAL_TEMPERATURE_RISE = "rise above the initial temperature at each sensor, linear between them"
_REFERENCE_TEMPERATURE = "temperature at which the elongation is 0; 0: the initial temperature"
_SENSOR_POSITION = "place of each sensor from the proximal end; -1 m: base, middle, tip, then evenly between"
_DISCRETISATION_ERROR = "estimate of the elongation's error from the finite grid"


def _varies(name: str, description: str) -> Parameter:
    """What a material's property changes by per kelvin: up to 695 K no less than a fifth of it is left."""
    return per_kelvin(name, description, within=(-2e-3, 5e-3), nominal=5e-4, rare=True)


_PARAMETERS = (
    length_parameter("length", 0.3302, "length of the link", positive=True, maximum=20),
    length_parameter("width", 0.0254, "width of the link", positive=True, maximum=1),
    length_parameter("thickness", 0.00635, "thickness of the link", positive=True, maximum=1),
    Parameter("cross_section", "m2", 0, _CROSS_SECTION, display="mm2", minimum=0, maximum=1),
    length_parameter("perimeter", 0, _PERIMETER, minimum=0, maximum=4),
    length_parameter("base_position", 0.0254, "where heat enters, from the proximal end", minimum=0),
    length_parameter("tip_position", 0.3170, "the tool point, from the proximal end", minimum=0),
    Parameter("conductivity", "W/(m.K)", 167, "thermal conductivity at 295.15 K", positive=True),
    per_kelvin(
        "conductivity_temperature_coefficient",
        "relative change of conductivity per kelvin above 295.15 K",
        within=(-0.01, 0.01),
        nominal=1e-3,
        rare=True,
    ),
    Parameter("density", "kg/m3", 2713, "density", positive=True),
    Parameter("specific_heat", "J/(kg.K)", 892, "specific heat capacity at 295.15 K", positive=True),
    _varies("specific_heat_temperature_coefficient", _SPECIFIC_HEAT),
    Parameter("expansion_coefficient", "1/K", 23.6e-6, _EXPANSION_COEFFICIENT, positive=True, nominal=2e-5),
    _varies("expansion_temperature_coefficient", _EXPANSION),
    tunable("convection_still", "W/(m2.K)", 4.55, "convection coefficient in still air", minimum=0),
    tunable("convection_per_speed", "W.s/(m3.K)", 6.4, _CONVECTION_PER_SPEED, minimum=0),
    extra("convection_mixing", "1", _MIXING, maximum=1.8, rare=True),
    extra("convection_rise_exponent", "1", _RISE, maximum=0.5, rare=True),
    extra("emissivity", "1", "emissivity of the surface; 0: no radiation", maximum=1, rare=True),
    tunable("absorbed_flux", "W/m2", 0, "radiant heat absorbed by the whole surface", nominal=10),
    extra("hub_conductance", "W/K", "heat loss from base position to the surroundings", nominal=0.1),
    Parameter("hub_heat_capacity", "J/K", 0, _HUB_HEAT_CAPACITY, minimum=0, nominal=10),
    Parameter("tip_heat_capacity", "J/K", 0, "heat capacity of what the tip carries", minimum=0, nominal=10),
    extra("tip_conductance", "W/K", "heat loss from tip position to its sink", nominal=0.1),
    *AMBIENT_ERROR,
    temperature_parameter("initial_temperature", "temperature at the start"),
    Parameter("initial_temperature_rise", "K", 0, _INITIAL_TEMPERATURE_RISE, size=SENSORS, nominal=1),
    Parameter("reference_temperature", "K", 0, _REFERENCE_TEMPERATURE, nominal=300, minimum=0),
    length_parameter("sensor_position", -1, _SENSOR_POSITION, size=SENSORS, minimum=-1),
)

_OUTPUTS = (
    temperature_output("base_temperature", "temperature at base position"),
    temperature_output("tip_temperature", "temperature at tip position"),
    temperature_output("sensor_temperature", "temperature at each sensor", size=SENSORS),
    growth_output("elongation", "growth between base and tip position"),
    Output("surface_heat_loss", "W", "heat lost by the surface", nominal=5),
    Output("heat_received", "J", "heat received at base position since the start", nominal=1e4),
    Output("discretisation_error", "m", _DISCRETISATION_ERROR, display="um", nominal=1e-7),
)


def _on_link(name: str, place: Callable[[Record], Number]) -> Check:
    beyond = "m lies beyond the link's end; keep it within length ({length} m)"
    return Check(lambda p: p.length - place(p), f"{name}: {{{name}}} {beyond}")


def _sensor_on_link(i: int) -> Check:
    return _on_link(f"sensor_position[{i + 1}]", lambda p: p.sensor_position[i])


_CHECKS = (
    _on_link("tip_position", lambda p: p.tip_position),
    Check(
        lambda p: p.tip_position - p.base_position - 1e-3 * p.length,
        "base_position: {base_position} m leaves no length before tip_position ({tip_position} m) "
        "on a link of length {length} m; put it nearer the proximal end, or correct the others",
    ),
    *map(_sensor_on_link, range(SENSORS)),
)


@cache
def thermal_link(cells: int) -> Component:
    """Declare a link of so many finite-volume cells (at least 8)."""
    return Component(
        name="ThermalLink",
        description="Slender robot link: conducts, stores and loses heat, and grows",
        inputs=_INPUTS,
        parameters=_PARAMETERS,
        derived=(
            Derived("conductance", "W/K", size=cells - 1),
            Derived("heat_capacity", "J/K", size=cells),
            Derived("rise_per_heat", "K/J", size=cells),
            Derived("surface_area", "m2", size=cells),
            Derived("sensor_weight", "1", size=SENSORS * cells),
        ),
        states=(State("temperature", "K", size=cells), State("heat_received", "J")),
        outputs=_OUTPUTS,
        terminals=(
            heat_port("base", "heat_flow", "base_temperature"),
            heat_port("tip", "tip_heat_flow", "tip_temperature"),
            bus("duty", "Duty", "speed", "ambient_temperature"),
        ),
        derive=partial(equations.derive, cells=cells),
        begin=partial(equations.begin, cells=cells),
        rates=equations.rates,
        observe=equations.outputs,
        local=(
            Local("conducted_heat_flow", "W", "from each node to the next", size=cells - 1, nominal=5),
            Local("surface_heat_flow", "W", "lost by the surface of each node", size=cells, nominal=0.1),
            Local("hub_heat_flow", "W", "from base position to the surroundings", nominal=1),
            Local("tip_sink_heat_flow", "W", "from tip position to its sink", nominal=1),
        ),
        look_inside=equations.heat_flows,
        checks=_CHECKS,
    )


COMPONENT = thermal_link(CELLS)

"""A reduced link as a component, with the connectors of ThermalLink."""

from dataclasses import replace
from functools import partial

from warmlink.fmus.component import Component, Derived, Output, Parameter, State
from warmlink.fmus.component.quantities import temperature_parameter, tunable
from warmlink.fmus.reduced_link import equations
from warmlink.fmus.reduced_link.equations import ReducedModel
from warmlink.fmus.thermal_link.component import COMPONENT as LINK

_OF_THE_SHAPE = (
    "length",
    "width",
    "thickness",
    "cross_section",
    "perimeter",
    "base_position",
    "tip_position",
    "sensor_position",
    "conductivity_temperature_coefficient",
    "specific_heat_temperature_coefficient",
    "expansion_temperature_coefficient",
    "convection_rise_exponent",
)
"""Parameters of ThermalLink that are fixed once a shape is reduced, or with which its heat is not linear."""

_BOUND = "estimated bound of the {} error due to the reduction"

_OUTPUTS = (
    *LINK.outputs,
    Output("displacement", "m", "displacement of the tool point", size=3, display="um", nominal=5e-5),
    Output("rotation", "rad", "rotation of the tool", size=3, nominal=1e-4),
    Output("displacement_error_bound", "m", _BOUND.format("displacement's"), display="um", nominal=1e-8),
    Output("rotation_error_bound", "rad", _BOUND.format("rotation's"), nominal=1e-7),
    Output("temperature_error_bound", "K", _BOUND.format("temperatures'"), nominal=5e-3),
)


def reduced_link(name: str, model: ReducedModel) -> Component:
    """Declare the component of a reduced link; its name is an identifier of C."""
    n, surfaces = model.order, model.area.size
    factor = "convection of each cooled surface as a multiple of the link's"
    return Component(
        name=name,
        description="Robot link of any shape: conducts, stores and loses heat, grows and bends",
        inputs=LINK.inputs,
        parameters=(
            *(_nominal(each, model) for each in LINK.parameters if each.name not in _OF_THE_SHAPE),
            tunable("convection_factor", "1", 1, factor, size=surfaces, minimum=0),
            temperature_parameter("radiation_temperature", "temperature about which radiation is linearised"),
        ),
        derived=(Derived("pattern_heat_capacity", "J/K", size=n),),
        states=(
            State("pattern_temperature", "K", size=n),
            State("heat_received", "J"),
            State("peak", "1", size=2 + 2 * surfaces),
        ),
        outputs=_OUTPUTS,
        derive=partial(equations.derive, model=model),
        begin=partial(equations.begin, model=model),
        rates=partial(equations.rates, model=model),
        solve=partial(equations.solve, model=model),
        observe=partial(equations.outputs, model=model),
    )


def _nominal(parameter: Parameter, model: ReducedModel) -> Parameter:
    """Parameter of ThermalLink with the start value of the part's material, within the range reduced for."""
    nominal = replace(parameter, start=model.material.get(parameter.name, parameter.start))
    if parameter.name != "conductivity":
        return nominal
    return replace(nominal, minimum=model.conductivity_range[0], maximum=model.conductivity_range[1])

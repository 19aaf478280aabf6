"""The motor as a source of heat, as a component."""

from warmlink.fmus.component import Component, Input, Local, Output, Parameter, State
from warmlink.fmus.component.quantities import (
    AMBIENT_ERROR,
    DUTY,
    bus,
    extra,
    heat_port,
    per_kelvin,
    temperature_input,
    temperature_output,
    temperature_parameter,
    tunable,
)
from warmlink.fmus.component.variables import Band
from warmlink.fmus.motor_heat_source import equations

_SPEED, _TORQUE, _AMBIENT_TEMPERATURE, _PAD_MODE, *_PAD = DUTY

_INPUTS = (
    _PAD_MODE,
    _SPEED,
    _TORQUE,
    Input("current", "A", "rms current, instead of the torque", nominal=2),
    *_PAD,
    _AMBIENT_TEMPERATURE,
    temperature_input("link_base_temperature", "temperature of the link at base position"),
    temperature_input("neighbour_temperature", "temperature of the neighbouring joint"),
    Input("added_shaft_heat", "W", "heat into the shaft that nothing else here makes", nominal=5),
    Input("added_winding_heat", "W", "heat into the winding that nothing else here makes", nominal=5),
)

_WINDING = Band(
    150.0,
    520.0,
    "copper loss grows with the square of the torque and with the winding's own temperature, so that beyond "
    "some torque nothing stops it; take less torque, or pauses",
)
"""K, up to which insulation lasts; enamel fails at some 250 degC."""

_HOUSING = "increase of the housing's conductance per speed, as by a fan on the shaft"
_COPPER = "relative change of resistance per kelvin (copper)"
_JOINT = "relative rise of the joint's conductance per kelvin of the shaft above 295.15 K"
_FRICTION = "relative decrease of friction per kelvin above 295.15 K"
_VISCOSITY = "exponent by which viscous friction falls per kelvin above 295.15 K"

_PARAMETERS = (
    Parameter("winding_heat_capacity", "J/K", 200, "heat capacity of the winding", positive=True),
    Parameter("shaft_heat_capacity", "J/K", 1500, "heat capacity of shaft and gear", positive=True),
    Parameter("winding_conductance", "W/K", 0.8, "thermal conductance from winding to shaft", minimum=0),
    tunable("housing_conductance", "W/K", 1.0, "thermal conductance from shaft to surroundings", minimum=0),
    extra("housing_conductance_per_speed", "W.s/(K.rad)", _HOUSING, nominal=0.1),
    Parameter("joint_conductance", "W/K", 1.0, "thermal conductance from shaft to link", minimum=0),
    extra("joint_resistance", "K/W", "additional thermal resistance of the joint, in series", nominal=0.1),
    extra("neighbour_conductance", "W/K", "thermal conductance to the neighbouring joint"),
    per_kelvin("joint_temperature_coefficient", _JOINT, within=(-0.02, 0.05)),
    Parameter("winding_resistance", "Ohm", 2.0, "resistance of the winding at 293.15 K", minimum=0),
    Parameter("winding_temperature_coefficient", "1/K", 0.0039, _COPPER, minimum=0, nominal=0.004),
    Parameter("torque_constant", "N.m/A", 1.2, "torque constant at the joint", positive=True),
    Parameter("iron_loss_coefficient", "W.s2/rad2", 0.15, "iron loss per squared speed", minimum=0),
    Parameter("coulomb_friction", "N.m", 1.5, "Coulomb friction torque", minimum=0),
    Parameter("viscous_friction", "N.m.s/rad", 0.6, "viscous friction torque per speed", minimum=0),
    tunable("friction_factor", "1", 1, "factor on both friction torques", minimum=0),
    per_kelvin("friction_temperature_coefficient", _FRICTION, within=(-0.1, 0.1)),
    per_kelvin("viscosity_temperature_coefficient", _VISCOSITY, within=(0, 0.2), rare=True),
    tunable("standby_power", "W", 0, "heat into the shaft at all times", nominal=1),
    extra(
        "moving_power",
        "W",
        "heat into the shaft while the joint moves, as a brake held open makes",
        nominal=1,
    ),
    tunable("pad_gain", "W/K", 20, "gain of the pad's temperature control", minimum=0),
    tunable("pad_power_limit", "W", 60, "largest power of the pad", minimum=0),
    *AMBIENT_ERROR,
    temperature_parameter("initial_winding_temperature", "temperature of the winding at the start"),
    temperature_parameter("initial_shaft_temperature", "temperature of the shaft at the start"),
)

_OUTPUTS = (
    Output("heat_flow", "W", "heat flow into the link", nominal=5),
    Output("neighbour_heat_flow", "W", "heat flow to the neighbouring joint", nominal=5),
    temperature_output("shaft_temperature", "temperature of the shaft"),
    temperature_output("winding_temperature", "temperature of the winding", plausible=_WINDING),
    Output("heat_delivered", "J", "heat delivered to the link since the start", nominal=1e4),
)

_LOCAL = (
    Local("copper_loss", "W", "Joule loss in the winding", nominal=20),
    Local("iron_loss", "W", "loss in the iron", nominal=1),
    Local("friction_loss", "W", "friction loss in bearings and gear", nominal=10),
    Local("pad_heat_flow", "W", "heat flow from the pad into the shaft", nominal=20),
    Local("winding_heat_flow", "W", "heat flow from the winding to the shaft", nominal=20),
    Local("housing_heat_flow", "W", "heat flow from the shaft through the housing to the air", nominal=20),
)

COMPONENT = Component(
    name="MotorHeatSource",
    description="Servo motor as a source of heat: winding and shaft, their losses and heat paths",
    inputs=_INPUTS,
    parameters=_PARAMETERS,
    states=(
        State("winding_temperature", "K", start="initial_winding_temperature"),
        State("shaft_temperature", "K", start="initial_shaft_temperature"),
        State("heat_delivered", "J"),
    ),
    outputs=_OUTPUTS,
    terminals=(
        heat_port("joint", "heat_flow", "link_base_temperature"),
        heat_port("neighbour", "neighbour_heat_flow", "neighbour_temperature"),
        bus("duty", "Duty", *(demand.name for demand in DUTY)),
    ),
    rates=equations.rates,
    observe=equations.outputs,
    local=_LOCAL,
    look_inside=equations.heat_flows,
)

"""Variables of kinds that occur in many components, so that unit, display and nominal stand once."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeVar

from warmlink.fmus.component import SHORTEST_SAMPLE_TIME, Choice, Input, Output, Parameter, Terminal, Variable
from warmlink.fmus.component.variables import NOMINAL_TEMPERATURE, Band, is_difference

ROOM_TEMPERATURE = 295.15
"""K, the temperature from which every cold start begins."""

PAD_MODE = Choice("PadMode", ("none", "power", "temperature"))
"""What a heating pad does: nothing, give a power, or be held at a temperature."""

_QUANTITIES = {
    "1/K": "LinearTemperatureCoefficient",
    "A": "ElectricCurrent",
    "J": "Energy",
    "J/(kg.K)": "SpecificHeatCapacity",
    "J/K": "HeatCapacity",
    "K": "ThermodynamicTemperature",
    "K/W": "ThermalResistance",
    "N.m": "Torque",
    "N.m.s/rad": "RotationalDampingConstant",
    "N.m/A": "ElectricalTorqueConstant",
    "Ohm": "Resistance",
    "W": "Power",
    "W/(m.K)": "ThermalConductivity",
    "W/(m2.K)": "CoefficientOfHeatTransfer",
    "W/K": "ThermalConductance",
    "W/m2": "DensityOfHeatFlowRate",
    "kg/m3": "Density",
    "m": "Length",
    "m/s": "Velocity",
    "m2": "Area",
    "rad": "Angle",
    "rad/s": "AngularVelocity",
    "s": "Time",
}

SI_UNITS = tuple(_QUANTITIES)
"""SI units of quantities that have a name."""


def quantity(variable: Variable) -> str | None:
    """Name of what a variable measures, as Modelica.Units.SI calls it; None for what has no name there."""
    return "TemperatureDifference" if is_difference(variable) else _QUANTITIES.get(variable.unit)


Declared = TypeVar("Declared", bound=Variable)


def _kind(made: Callable[..., Declared], unit: str, **fixed: Any) -> Callable[..., Declared]:
    """What declares variables of a kind: by name, start where they have one, description, and more."""
    return lambda name, *told, **more: made(name, unit, *told, **{**fixed, **more})


_GROWTH: dict[str, Any] = {"display": "um", "nominal": 5e-5}

TEMPERATURES = Band(150.0, 600.0)
"""K, in which metals conduct, store heat and grow about as declared: aluminium melts at 930 K."""

GROWTHS = Band(-0.01, 0.01)
"""m, for links of metal of a few metres at most."""

_TEMPERATURE: dict[str, Any] = {
    "display": "degC",
    "nominal": NOMINAL_TEMPERATURE,
    "plausible": TEMPERATURES,
}

temperature_input = _kind(Input, "K", start=ROOM_TEMPERATURE, minimum=0, **_TEMPERATURE)
"""Absolute temperature in K, read in degC, at room temperature where nothing is connected."""

temperature_output = _kind(Output, "K", **_TEMPERATURE)
"""Absolute temperature in K, read in degC, of a thing; a reading that may be wrong has no plausible band."""

growth_input = _kind(Input, "m", **_GROWTH)
"""Growth of a link in m, or what makes up for it, read in um."""

growth_output = _kind(Output, "m", plausible=GROWTHS, **_GROWTH)
"""Growth of a link in m, read in um."""

growth_told = _kind(Output, "m", **_GROWTH)
"""What a camera or controller says of a growth in m, read in um, right or wrong."""

length_parameter = _kind(Parameter, "m", display="mm")
"""Length or place in m, read in mm."""


def temperature_parameter(name: str, description: str) -> Parameter:
    """Absolute temperature in K, read in degC, room temperature by default."""
    return Parameter(name, "K", ROOM_TEMPERATURE, description, positive=True, **_TEMPERATURE)


def sample_time_parameter(description: str) -> Parameter:
    """Time in s between two samples, the same bounds for whatever samples."""
    return Parameter("sample_time", "s", 1.0, description, minimum=SHORTEST_SAMPLE_TIME)


def per_kelvin(
    name: str, description: str, within: tuple[float, float], nominal: float = 0.01, rare: bool = False
) -> Parameter:
    """Relative change per kelvin, none unless it is given, and the least and the largest that it may be."""
    low, high = within
    return Parameter(name, "1/K", 0, description, minimum=low, maximum=high, nominal=nominal, rare=rare)


def heat_port(name: str, heat_flow: str, temperature: str) -> Terminal:
    """Place where heat passes: one side gives the heat flow, the other the temperature."""
    return Terminal(name, "HeatPort", (("heat_flow", heat_flow), ("temperature", temperature)))


def bus(name: str, kind: str, *scalars: str) -> Terminal:
    """Terminal whose members bear the names of their scalars."""
    return Terminal(name, kind, tuple((scalar, scalar) for scalar in scalars))


def thermometers(name: str, scalars: Sequence[str]) -> Terminal:
    """Temperatures in the order of a system's thermometers, as members `channel_1` and so on."""
    channels = ((f"channel_{i}", scalar) for i, scalar in enumerate(scalars, start=1))
    return Terminal(name, "Thermometers", tuple(channels))


AMBIENT_TEMPERATURE = temperature_input("ambient_temperature", "temperature of the surroundings")
SPEED = Input("speed", "rad/s", "mean absolute speed of the joint", nominal=3)

_PAD_MODES = "heating pad: 0 none, 1 a given power, 2 held at a temperature"

DUTY = (
    SPEED,
    Input("torque", "N.m", "rms torque at the joint", nominal=2.5),
    AMBIENT_TEMPERATURE,
    Input("pad_mode", "1", _PAD_MODES, choice=PAD_MODE, discrete=True),
    temperature_input("pad_temperature", "temperature the pad is held at (mode 2)"),
    Input("pad_power", "W", "power of the pad (mode 1)", nominal=20),
)
"""What a duty cycle demands of a joint, and a motor is told."""

tunable = partial(Parameter, tunable=True)
"""A parameter that may change between communication steps."""


def extra(name: str, unit: str, description: str, **more: Any) -> Parameter:
    """Tunable parameter of something that is not there unless asked for: 0, and never below."""
    return tunable(name, unit, 0, description, minimum=0, **more)


_MISSED = "true minus given ambient temperature"

AMBIENT_ERROR = (
    tunable("ambient_offset", "K", 0, _MISSED, nominal=1),
    tunable("ambient_drift", "K/s", 0, f"rise with time of {_MISSED}", display="K/h", nominal=1e-4),
)
"""What a log of the surroundings' temperature may miss."""

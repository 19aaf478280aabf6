"""The paper's expression as a compensating controller."""

from warmlink.controllers.analytic import law
from warmlink.controllers.fail_safe import LIMITS
from warmlink.controllers.interface import compensator, error_parameters
from warmlink.fmus.component import Choice, Parameter, State
from warmlink.fmus.component.quantities import length_parameter
from warmlink.fmus.component.variables import NOMINAL_TEMPERATURE
from warmlink.fmus.thermal_link.component import COMPONENT as LINK

_MATERIAL = {"conductivity", "density", "specific_heat", "expansion_coefficient"}

_LEAP = "change between two readings beyond which a sensor is not believed"
_FORM = Choice("EquationForm", ("printed", "corrected"))
_SOURCE = Choice("TemperatureSource", ("base", "shaft"))
_REFERENCE = "temperature at which the elongation is 0; 0: the first good reading"
_RISE = "rise at which the time of heating begins to count"

_PARAMETERS = (
    *LIMITS,
    Parameter("largest_leap", "K", 2, _LEAP, positive=True, nominal=1),
    Parameter("form", "1", law.CORRECTED, "Eq. (4): 0 as printed, 1 corrected", choice=_FORM),
    Parameter("temperature_source", "1", law.BASE, "thermometer used: 0 base, 1 shaft", choice=_SOURCE),
    length_parameter("heated_length", 0.2916, "length from base to tip position", positive=True, maximum=20),
    *(parameter for parameter in LINK.parameters if parameter.name in _MATERIAL),
    Parameter("reference_temperature", "K", 0, _REFERENCE, minimum=0, nominal=NOMINAL_TEMPERATURE),
    Parameter("heating_rise", "K", 0.5, _RISE, minimum=0, nominal=0.5),
    *error_parameters(1e-6),
)

COMPONENT = compensator(
    "AnalyticCompensator",
    "Growth by the paper's Eq. (4), from the temperature at the base and the time of heating",
    law,
    _PARAMETERS,
    (
        *(State(name, "K") for name in ("reference", "held")),
        *(State(name, "s") for name in ("waited", "unheard_for", "heated_for")),
        *(State(name, "m") for name in ("elongation", "correction")),
        *(State(name, "1") for name in ("warm", "distrusted")),
    ),
)

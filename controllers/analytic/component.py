"""The paper's expression as a compensating controller."""

from __future__ import annotations

from warmlink.controllers.analytic import law
from warmlink.controllers.fail_safe import LIMITS
from warmlink.controllers.interface import INPUTS, OUTPUTS, SAMPLE_TIME, TERMINALS, TOLERANCE
from warmlink.controllers.verdict import error_parameters
from warmlink.fmus.component import Choice, Component, Parameter, State
from warmlink.fmus.component.quantities import NOMINAL_TEMPERATURE
from warmlink.fmus.thermal_link.component import COMPONENT as LINK

_MATERIAL = tuple(
    parameter
    for parameter in LINK.parameters
    if parameter.name in {"conductivity", "density", "specific_heat", "expansion_coefficient"}
)

_FORM = Choice("EquationForm", ("printed", "corrected"))
_SOURCE = Choice("TemperatureSource", ("base", "shaft"))

_PARAMETERS = (
    SAMPLE_TIME,
    TOLERANCE,
    *LIMITS,
    Parameter(
        "largest_leap",
        "K",
        2,
        "change between two readings beyond which a sensor is not believed",
        positive=True,
        nominal=1,
    ),
    Parameter(
        "form",
        "1",
        law.CORRECTED,
        "Eq. (4): 0 as printed, 1 corrected",
        type="Integer",
        choice=_FORM,
        minimum=0,
        maximum=_FORM.last,
    ),
    Parameter(
        "temperature_source",
        "1",
        law.BASE,
        "thermometer used: 0 base, 1 shaft",
        type="Integer",
        choice=_SOURCE,
        minimum=0,
        maximum=_SOURCE.last,
    ),
    Parameter("heated_length", "m", 0.2916, "length from base to tip position", display="mm", positive=True),
    *_MATERIAL,
    Parameter(
        "reference_temperature",
        "K",
        0,
        "temperature at which the elongation is 0; 0: the first good reading",
        minimum=0,
        nominal=NOMINAL_TEMPERATURE,
    ),
    Parameter(
        "heating_rise", "K", 0.5, "rise at which the time of heating begins to count", minimum=0, nominal=0.5
    ),
    *error_parameters(1e-6),
)

COMPONENT = Component(
    name="AnalyticCompensator",
    description="Growth by the paper's Eq. (4), from the temperature at the base and the time of heating",
    inputs=INPUTS,
    terminals=TERMINALS,
    parameters=_PARAMETERS,
    states=(
        State("reference", "K"),
        State("held", "K"),
        State("missing_for", "s"),
        State("heated_for", "s"),
        State("elongation", "m"),
        State("correction", "m"),
        State("distrusted", "1"),
    ),
    outputs=OUTPUTS,
    update=law.update,
    begin=law.begin,
    observe=law.outputs,
)

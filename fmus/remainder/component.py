"""The remainder as a component."""

from warmlink.fmus.component import Component, Input, Output, Parameter, State
from warmlink.fmus.component.quantities import (
    AMBIENT_TEMPERATURE,
    temperature_input,
    temperature_output,
    temperature_parameter,
)
from warmlink.fmus.remainder import equations
from warmlink.fmus.remainder.equations import FEATURES, LAGS, TEMPERATURES, TIME_CONSTANTS

_PER_TEMPERATURE = TEMPERATURES * LAGS

COMPONENT = Component(
    name="Remainder",
    description="What a model still gets wrong, learnt from logs: weighted lags of what drives the machine",
    inputs=(
        temperature_input("temperature", "temperatures of the model that are corrected", size=TEMPERATURES),
        AMBIENT_TEMPERATURE,
        Input("elongation", "m", "growth by the model", display="um", nominal=50e-6),
        Input("speed", "rad/s", "mean absolute speed of the joint", nominal=3),
        Input("torque", "N.m", "rms torque of the joint", nominal=2),
        Input("current", "A", "rms current", nominal=2),
        Input("power", "W", "power of a heater", nominal=10),
    ),
    parameters=(
        Parameter("time_constant", "s", 600, "time constant of each lag", size=TIME_CONSTANTS, positive=True),
        Parameter(
            "scale", "1", 1, "usual size of each feature, in its SI unit", size=FEATURES, positive=True
        ),
        temperature_parameter("reference_temperature", "from which that of the surroundings counts"),
        Parameter(
            "temperature_weight",
            "K",
            0,
            "added to each temperature by each lag of a feature of its usual size",
            size=_PER_TEMPERATURE,
            nominal=1,
        ),
        Parameter(
            "temperature_gain",
            "1",
            0,
            "added to each temperature, as a share of its rise above ambient",
            size=TEMPERATURES,
            nominal=0.1,
        ),
        Parameter("elongation_gain", "1", 0, "added to the growth, as a share of it", nominal=0.1),
        Parameter(
            "temperature_offset", "K", 0, "always added to each temperature", size=TEMPERATURES, nominal=1
        ),
        Parameter(
            "elongation_weight",
            "m",
            0,
            "added to the growth by each lag of a feature of its usual size",
            size=LAGS,
            display="um",
            nominal=1e-6,
        ),
        Parameter("elongation_offset", "m", 0, "always added to the growth", display="um", nominal=1e-6),
        Parameter(
            "least", "1", -1e9, "least value of each lag in what was learnt from", size=LAGS, nominal=1
        ),
        Parameter("largest", "1", 1e9, "largest value of each lag there", size=LAGS, nominal=1),
        Parameter(
            "temperature_error",
            "K",
            0,
            "what was left of each temperature's error in held-out blocks, 1 sigma",
            size=TEMPERATURES,
            minimum=0,
            nominal=0.1,
        ),
        Parameter(
            "elongation_error",
            "m",
            0,
            "what was left of the growth's error in held-out blocks, 1 sigma",
            minimum=0,
            display="um",
            nominal=1e-6,
        ),
    ),
    states=(State("lagged", "1", size=LAGS),),
    outputs=(
        temperature_output(
            "corrected_temperature", "temperatures with the remainder", size=TEMPERATURES, plausible=None
        ),
        Output("corrected_elongation", "m", "growth with the remainder", display="um", nominal=50e-6),
        Output("outside", "1", "how far the lags are outside what was learnt from; 0: inside", nominal=1),
        Output(
            "temperature_spread", "K", "1 sigma of the corrected temperatures", size=TEMPERATURES, nominal=0.1
        ),
        Output("elongation_spread", "m", "1 sigma of the corrected growth", display="um", nominal=1e-6),
    ),
    rates=equations.rates,
    observe=equations.outputs,
)

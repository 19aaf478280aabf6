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
    description="What a model still gets wrong, learnt from logs: weighted first-order lags of speed, "
    "torque, current, power and temperatures",
    inputs=(
        temperature_input("temperature", "temperatures of the model that are corrected", size=TEMPERATURES),
        AMBIENT_TEMPERATURE,
        Input("elongation", "m", "elongation by the model, which is corrected", display="um", nominal=50e-6),
        Input("speed", "rad/s", "mean absolute speed of the joint", nominal=3),
        Input("torque", "N.m", "rms torque of the joint", nominal=2),
        Input("current", "A", "rms current", nominal=2),
        Input("power", "W", "power of the motor's heating pad", nominal=10),
    ),
    parameters=(
        Parameter(
            "time_constant",
            "s",
            600,
            "time constants; every feature has a lag with each",
            size=TIME_CONSTANTS,
            positive=True,
        ),
        Parameter(
            "scale",
            "1",
            1,
            "usual size of each feature, in its SI unit: speed, speed squared, speed times torque, "
            "torque squared, current squared, power, ambient_temperature, each temperature",
            size=FEATURES,
            positive=True,
        ),
        temperature_parameter(
            "reference_temperature", "subtracted from the ambient temperature, as a feature"
        ),
        Parameter(
            "temperature_weight",
            "K",
            0,
            "added to each temperature by each lag of a feature of its usual size; in the order of "
            "temperature, time constant, feature",
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
            "added to the growth by each lag of a feature of its usual size; in the order of "
            "time constant, feature",
            size=LAGS,
            display="um",
            nominal=1e-6,
        ),
        Parameter("elongation_offset", "m", 0, "always added to the growth", display="um", nominal=1e-6),
        Parameter(
            "least",
            "1",
            -1e9,
            "lowest value of each lag in the logs; below it `outside` grows, nothing is clamped",
            size=LAGS,
            nominal=1,
        ),
        Parameter(
            "largest",
            "1",
            1e9,
            "highest value of each lag in the logs; beyond it `outside` grows, nothing is clamped",
            size=LAGS,
            nominal=1,
        ),
        Parameter(
            "temperature_error",
            "K",
            0,
            "rms error of each temperature after correction, on blocks left out of the fit; 0: nothing was "
            "learnt",
            size=TEMPERATURES,
            minimum=0,
            nominal=0.1,
        ),
        Parameter(
            "elongation_error",
            "m",
            0,
            "rms error of the growth after correction, on blocks left out of the fit; 0: nothing was learnt",
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
        Output(
            "outside",
            "1",
            "sum over all lags of the excess over least/largest, in usual sizes; 0: inside",
            nominal=1,
        ),
        Output(
            "temperature_spread",
            "K",
            "1 sigma of the corrected temperatures, times (1 + outside); 0: nothing was learnt",
            size=TEMPERATURES,
            nominal=0.1,
        ),
        Output(
            "elongation_spread",
            "m",
            "1 sigma of the corrected growth, times (1 + outside); 0: nothing was learnt",
            display="um",
            nominal=1e-6,
        ),
    ),
    rates=equations.rates,
    observe=equations.outputs,
)

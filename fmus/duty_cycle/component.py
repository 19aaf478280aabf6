"""The duty cycle as a component."""

from __future__ import annotations

from dataclasses import replace

from warmlink.fmus.component import Check, Component, Derived, Output, Parameter
from warmlink.fmus.component.arithmetic import total
from warmlink.fmus.component.quantities import NOMINAL_TEMPERATURE, ROOM_TEMPERATURE, temperature_output
from warmlink.fmus.duty_cycle import equations

SEGMENTS = equations.SEGMENTS

_UNUSED = (0.0,) * (SEGMENTS - 1)

_PARAMETERS = (
    Parameter(
        "duration",
        "s",
        0,
        "how long each segment lasts; 0: not used",
        size=SEGMENTS,
        starts=(7200.0, *_UNUSED),
        minimum=0,
        maximum=equations.LONGEST,
        nominal=3600,
    ),
    Parameter(
        "segment_speed",
        "rad/s",
        0,
        "mean absolute speed of the joint",
        size=SEGMENTS,
        starts=(3.43, *_UNUSED),
        minimum=0,
        nominal=3,
        tunable=True,
    ),
    Parameter(
        "segment_torque",
        "N.m",
        0,
        "rms torque at the joint",
        size=SEGMENTS,
        starts=(2.5, *_UNUSED),
        minimum=0,
        nominal=2.5,
        tunable=True,
    ),
    Parameter(
        "segment_ambient_temperature",
        "K",
        ROOM_TEMPERATURE,
        "temperature of the surroundings",
        size=SEGMENTS,
        display="degC",
        nominal=NOMINAL_TEMPERATURE,
        positive=True,
        tunable=True,
    ),
    Parameter(
        "segment_pad_mode",
        "1",
        0,
        "heating pad: 0 none, 1 a given power, 2 held at a temperature",
        size=SEGMENTS,
        type="Integer",
        minimum=0,
        maximum=2,
        tunable=True,
    ),
    Parameter(
        "segment_pad_temperature",
        "K",
        ROOM_TEMPERATURE,
        "temperature the pad is held at (mode 2)",
        size=SEGMENTS,
        display="degC",
        nominal=NOMINAL_TEMPERATURE,
        positive=True,
        tunable=True,
    ),
    Parameter(
        "segment_pad_power",
        "W",
        0,
        "power of the pad (mode 1)",
        size=SEGMENTS,
        minimum=0,
        nominal=20,
        tunable=True,
    ),
    Parameter("repeat", "1", 0, "whether the segments begin again after the last", type="Boolean"),
)

COMPONENT = Component(
    name="DutyCycle",
    description="Duty cycle of up to 32 segments; the last one holds, or all begin again",
    parameters=_PARAMETERS,
    derived=(
        Derived("segment_begin", "s", size=SEGMENTS),
        Derived("length", "s"),
    ),
    # Discrete: they jump from segment to segment, so that no master may interpolate them over a step.
    outputs=(
        Output("speed", "rad/s", "mean absolute speed of the joint", nominal=3, discrete=True),
        Output("torque", "N.m", "rms torque at the joint", nominal=2.5, discrete=True),
        replace(temperature_output("ambient_temperature", "temperature of the surroundings"), discrete=True),
        Output(
            "pad_mode",
            "1",
            "heating pad: 0 none, 1 a given power, 2 held at a temperature",
            type="Integer",
            discrete=True,
        ),
        replace(
            temperature_output("pad_temperature", "temperature the pad is held at (mode 2)"), discrete=True
        ),
        Output("pad_power", "W", "power of the pad (mode 1)", nominal=20, discrete=True),
    ),
    derive=equations.derive,
    observe=equations.outputs,
    checks=(
        Check(
            lambda p: total(p.duration) - 1e-3,
            "duration[1]: {duration[1]} s, and no other segment lasts longer; "
            "give at least one segment 0.001 s or more",
        ),
    ),
)

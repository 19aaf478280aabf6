"""Variables of kinds that occur in many components, so that unit, display and nominal stand once."""

from __future__ import annotations

from warmlink.fmus.component import SHORTEST_SAMPLE_TIME, Input, Output, Parameter

ROOM_TEMPERATURE = 295.15
"""K, the temperature from which every cold start begins."""

NOMINAL_TEMPERATURE = 300.0
"""K, by which tolerances on temperatures are scaled."""


def temperature_input(name: str, description: str) -> Input:
    """Absolute temperature in K, read in degC, at room temperature where nothing is connected."""
    return Input(
        name,
        "K",
        description,
        start=ROOM_TEMPERATURE,
        display="degC",
        nominal=NOMINAL_TEMPERATURE,
        minimum=0,
    )


def temperature_parameter(name: str, description: str) -> Parameter:
    """Absolute temperature in K, read in degC, room temperature by default."""
    return Parameter(
        name,
        "K",
        ROOM_TEMPERATURE,
        description,
        display="degC",
        nominal=NOMINAL_TEMPERATURE,
        positive=True,
    )


def temperature_output(name: str, description: str, size: int | None = None) -> Output:
    """Absolute temperature in K, read in degC."""
    return Output(name, "K", description, size=size, display="degC", nominal=NOMINAL_TEMPERATURE)


def sample_time_parameter(description: str) -> Parameter:
    """Time in s between two samples, the same bounds for whatever samples."""
    return Parameter("sample_time", "s", 1.0, description, minimum=SHORTEST_SAMPLE_TIME)


AMBIENT_TEMPERATURE = temperature_input("ambient_temperature", "temperature of the surroundings")

AMBIENT_ERROR = (
    Parameter("ambient_offset", "K", 0, "true minus given ambient temperature", nominal=1, tunable=True),
    Parameter(
        "ambient_drift",
        "K/s",
        0,
        "true minus given ambient temperature, per second",
        display="K/h",
        nominal=1e-4,
        tunable=True,
    ),
)
"""What a log of the surroundings' temperature may miss."""

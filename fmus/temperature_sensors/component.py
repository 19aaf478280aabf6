"""The thermometers as a component."""

from functools import partial

from warmlink.fmus import faults
from warmlink.fmus.component import Check, Component, Derived, Local, Parameter, State
from warmlink.fmus.component.arithmetic import where
from warmlink.fmus.component.quantities import (
    AMBIENT_TEMPERATURE,
    bus,
    sample_time_parameter,
    temperature_input,
    temperature_output,
    thermometers,
    tunable,
)
from warmlink.fmus.temperature_sensors import equations

CHANNELS = equations.CHANNELS

_each = partial(tunable, size=CHANNELS)

_STEM_CONDUCTION = "share of the rise above ambient temperature that the stem conducts away"

_PARAMETERS = (
    sample_time_parameter("time between two readings"),
    _each("noise", "K", 0, "standard deviation of a reading", minimum=0, nominal=0.1),
    _each("offset", "K", 0, "reading minus temperature", nominal=0.1),
    _each("lag", "s", 0, "time constant of the first-order lag", minimum=0, nominal=10),
    _each("stem_conduction", "1", 0, _STEM_CONDUCTION, minimum=0, maximum=1, nominal=0.01),
    _each("quantum", "K", 0, "step between readings; 0: none", minimum=0, nominal=0.1),
    *faults.parameters("K", "K", 1, 1e-4, CHANNELS),
    Parameter("seed", "1", 1, "seed of the noise", type="Integer", minimum=0),
)


def _not_too_fine(i: int) -> Check:
    """No thermometer resolves less, and whole numbers of much finer quanta overflow."""
    return Check(
        lambda p: where(p.quantum[i] > 0, p.quantum[i] - equations.FINEST_QUANTUM, 0.0),
        f"quantum[{i + 1}]: {{quantum[{i + 1}]}} K is too fine; give 0 for none or at least "
        f"{equations.FINEST_QUANTUM:g} K",
    )


COMPONENT = Component(
    name="TemperatureSensors",
    description="Eight thermometers: noise, offset, lag, stem conduction, quantum, and faults",
    inputs=(
        temperature_input("temperature", "true temperature at each sensor", size=CHANNELS),
        AMBIENT_TEMPERATURE,
    ),
    parameters=_PARAMETERS,
    checks=tuple(_not_too_fine(i) for i in range(CHANNELS)),
    states=(
        State("sensed", "K", size=CHANNELS),
        State("reading", "K", size=CHANNELS, accepts_nan=True),
        State("generator_a", "1", size=CHANNELS),
        State("generator_b", "1", size=CHANNELS),
    ),
    outputs=(
        temperature_output(
            "reading",
            "reading of each sensor; NaN where it dropped out",
            size=CHANNELS,
            plausible=None,
        ),
    ),
    terminals=(
        thermometers("places", [f"temperature[{i}]" for i in range(1, CHANNELS + 1)]),
        thermometers("readings", [f"reading[{i}]" for i in range(1, CHANNELS + 1)]),
        bus("duty", "Duty", "ambient_temperature"),
    ),
    derived=(Derived("kept", "1", size=CHANNELS),),
    derive=equations.derive,
    update=equations.update,
    begin=equations.begin,
    observe=equations.outputs,
    local=(Local("sensed", "K", "temperature of each sensor itself", size=CHANNELS, display="degC"),),
    look_inside=lambda x, u, p, time: {"sensed": x.sensed},
)

"""The duty cycle as a component."""

from typing import Any

from warmlink.fmus.component import Check, Component, Derived, Output, Parameter
from warmlink.fmus.component.arithmetic import total
from warmlink.fmus.component.quantities import DUTY, ROOM_TEMPERATURE, bus, tunable
from warmlink.fmus.duty_cycle import equations

SEGMENTS = equations.SEGMENTS

TIMES = (Derived("segment_begin", "s", size=SEGMENTS), Derived("length", "s"))
"""When each segment begins, and the time that all take."""


def durations(description: str, first: float, ordinary: float) -> Parameter:
    """Times in s that segments last, the first of them as shipped; 0 for those that are not used."""
    about, starts = f"{description}; 0: not used", (first, *(0.0,) * (SEGMENTS - 1))
    bounds: dict[str, Any] = {"minimum": 0, "maximum": equations.LONGEST, "nominal": ordinary}
    return Parameter("duration", "s", 0, about, size=SEGMENTS, starts=starts, **bounds)


def lasting(part: str, lasts: str) -> Check:
    """Check that a segment lasts; `part` and `lasts` are words of its sentence, as "pose" and "is held"."""
    return Check(
        lambda p: total(p.duration) - 1e-3,
        f"duration[1]: {{duration[1]}} s, and no other {part} {lasts} longer; "
        f"give at least one {part} 0.001 s or more",
    )


# Discrete: they jump from segment to segment, so that no master may interpolate them over a step.
_DEMANDS = tuple(
    Output(
        v.name,
        v.unit,
        v.description,
        display=v.display,
        nominal=v.nominal,
        plausible=v.plausible,
        choice=v.choice,
        discrete=True,
    )
    for v in DUTY
)

_SHIPPED = {"speed": 3.43, "torque": 2.5}
"""What the first segment demands as shipped."""


def _in_segments(demand: Output) -> Parameter:
    """A demand in each segment."""
    start, first = 0.0, _SHIPPED.get(demand.name)
    more: dict[str, Any] = {"choice": demand.choice, "display": demand.display, "nominal": demand.nominal}
    if demand.display == "degC":
        start, more["positive"] = ROOM_TEMPERATURE, True
    else:
        more["minimum"] = 0
    starts = None if first is None else (first, *(0.0,) * (SEGMENTS - 1))
    name, about = f"segment_{demand.name}", demand.description
    return tunable(name, demand.unit, start, about, size=SEGMENTS, starts=starts, **more)


COMPONENT = Component(
    name="DutyCycle",
    description="Duty cycle of up to 32 segments; the last one holds, or all begin again",
    parameters=(
        durations("how long each segment lasts", 7200.0, 3600),
        *map(_in_segments, _DEMANDS),
        Parameter("repeat", "1", 0, "whether the segments begin again after the last", type="Boolean"),
    ),
    derived=TIMES,
    outputs=_DEMANDS,
    terminals=(bus("duty", "Duty", *(demand.name for demand in _DEMANDS)),),
    derive=equations.derive,
    observe=equations.outputs,
    checks=(lasting("segment", "lasts"),),
)

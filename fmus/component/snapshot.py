"""All that a component remembers in Python, and whether it is something that it could have remembered."""

import math
from dataclasses import dataclass
from typing import Any

from warmlink.fmus.component import Component, limits

TICK_TOLERANCE = 1e-9
"""Share of a sample time, or of a micro step, by which a communication point may miss it."""

CLOCK_TOLERANCE = 1e-6
"""Share of time and step by which a master's sum of steps may miss our time."""

VECTORS = ("parameters", "inputs", "states")
"""Fields of a snapshot that are vectors of floats."""


@dataclass(frozen=True)
class Snapshot:
    """All that an instance remembers; JSON-ready, and exact since floats are written in full."""

    parameters: list[float]
    inputs: list[float]
    states: list[float]
    start_time: float
    time: float
    samples: list[int]
    initialized: bool


def samples_until(time: float, start_time: float, period: float) -> int:
    """Samples from the start until a time, all in s."""
    return math.floor((time - start_time) / period + TICK_TOLERANCE)


def is_possible(component: Component, snapshot: Snapshot) -> bool:
    """Whether an instance of a component could have remembered this, whatever the fields hold."""
    sizes = (component.p.size, component.u.size, component.x.size)
    vectors = (getattr(snapshot, name) for name in VECTORS)
    start, time, samples = snapshot.start_time, snapshot.time, snapshot.samples
    if not (
        all(_are_numbers(vector, size) for vector, size in zip(vectors, sizes, strict=True))
        and _are_numbers([start, time], 2)
        and math.isfinite(start)
        and math.isfinite(time)
        and isinstance(samples, list)
        and [type(each) for each in samples] == [int] * len(component.clocks)
        and type(snapshot.initialized) is bool
    ):
        return False
    for scalar, value in zip(component.scalars(), snapshot.parameters + snapshot.inputs, strict=False):
        kind = scalar.variable.type
        if kind == "Boolean" and value not in (0, 1):
            return False
        if kind == "Integer" and not (math.isfinite(value) and value == round(value)):
            return False
    if not snapshot.initialized:
        return time == start and not any(samples)
    # Time by which masters' sums of steps may have missed ours.
    slack = 4 * CLOCK_TOLERANCE * (abs(start) + abs(time))
    refused = any(limits.problems(component, "", snapshot.parameters))
    if refused or limits.wild_state(component, snapshot.states) is not None or time < start - slack:
        return False
    for clock, count in zip(component.clocks, samples, strict=True):
        period = snapshot.parameters[component.p.index[clock.sample_time]]
        if not math.isfinite((time - start) / period):
            return False
        due = max(0, samples_until(time, start, period))
        if not due <= count <= due + 1 + slack / period:
            return False
    return True


def _are_numbers(values: Any, size: int) -> bool:
    return isinstance(values, list) and len(values) == size and all(isinstance(v, float) for v in values)

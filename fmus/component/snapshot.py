"""All that a component remembers in Python, and whether it is something that it could have remembered."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from warmlink.fmus.component import Component, VariableType, limits

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


def contradiction(component: Component, snapshot: Snapshot) -> str | None:
    """What no instance could have remembered, whatever the fields hold; None where all is well.

    Parameters
    ----------
    component : the declaration
    snapshot : as it was read from somewhere
    """
    sizes = (component.p.size, component.u.size, component.x.size)
    vectors = (getattr(snapshot, name) for name in VECTORS)
    if not all(_numbers(vector, size) for vector, size in zip(vectors, sizes, strict=True)):
        return "its values are not as many numbers as there are variables"
    if type(snapshot.initialized) is not bool:
        return "no phase of a run is the one in it"
    if not _times_are_well(snapshot):
        return "its times contradict each other"
    for scalar, value in zip(component.scalars(), snapshot.parameters + snapshot.inputs, strict=False):
        if not _fits(scalar.variable.type, value):
            return "an integer or a boolean in it is none"
    if snapshot.initialized:
        for sentence in limits.problems(component, component.snake_name, snapshot.parameters):
            return f"in it, {sentence}"
        wild = limits.wild_state(component, snapshot.states)
        if wild is not None:
            return f"{wild} in it is not finite"
    if not _samples_are_well(component, snapshot):
        return "its number of samples contradicts its time"
    return None


def _numbers(values: Any, size: int) -> bool:
    return isinstance(values, list) and len(values) == size and all(isinstance(v, float) for v in values)


def _fits(kind: VariableType, value: float) -> bool:
    if kind == "Boolean":
        return value in (0, 1)
    return kind == "Real" or (math.isfinite(value) and value == round(value))


def _times_are_well(snapshot: Snapshot) -> bool:
    start, time = snapshot.start_time, snapshot.time
    if not (_numbers([start, time], 2) and math.isfinite(start) and math.isfinite(time)):
        return False
    return time >= start - _slack(snapshot) if snapshot.initialized else time == start


def _slack(snapshot: Snapshot) -> float:
    """Time in s by which masters' sums of steps may have missed it."""
    return 4 * CLOCK_TOLERANCE * (abs(snapshot.start_time) + abs(snapshot.time))


def _samples_are_well(component: Component, snapshot: Snapshot) -> bool:
    if not isinstance(snapshot.samples, list) or len(snapshot.samples) != len(component.clocks):
        return False
    duration = snapshot.time - snapshot.start_time
    for clock, samples in zip(component.clocks, snapshot.samples, strict=True):
        if type(samples) is not int:
            return False
        if not snapshot.initialized:
            if samples:
                return False
            continue
        period = snapshot.parameters[component.p.index[clock.sample_time]]
        if not math.isfinite(duration / period):
            return False
        due = max(0, samples_until(snapshot.time, snapshot.start_time, period))
        if not due <= samples <= due + 1 + _slack(snapshot) / period:
            return False
    return True

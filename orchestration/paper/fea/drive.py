"""What acts on the body over time: convection, ambient, and the temperature or heat flow at the shaft."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array

Course = float | Callable[[float], float]
"""A constant, or a function of time [s]; where it jumps, a time step must end."""

JUST_BEFORE = 1 - 1e-9
"""Share of a step up to which it feels what acts; a jump at its end belongs to the next one."""


def within(course: Course, start: float, step: float, fraction: float) -> float:
    """Value at `start + fraction * step` as the step from `start` of length `step` [s] sees it."""
    return float(course(start + min(fraction, JUST_BEFORE) * step) if callable(course) else course)


def held(times: ArrayLike, values: Sequence[float]) -> Course:
    """Samples at increasing times [s], each of which holds until the next; the first also before its time."""
    return lambda time: values[max(int(np.searchsorted(times, time, side="right")) - 1, 0)]


@dataclass(frozen=True)
class Drive:
    """Everything that acts from outside.

    `convection` [W/(m2.K)] on the surfaces named in `cooled` (None: all free surfaces), `ambient` [K], and
    either `temperature` [K] or `heat_flow` [W] at the heated boundary. With `radiation` the cooled surfaces
    exchange heat with the ambient by their materials' emissivity.
    """

    convection: Course
    ambient: Course
    temperature: Course | None = None
    heat_flow: Course | None = None
    radiation: bool = False
    cooled: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        if (self.temperature is None) == (self.heat_flow is None):
            raise InputError("drive: give either temperature or heat_flow at the heated boundary, not both")


def graded(breakpoints: Sequence[float]) -> Array:
    """Times [s] from the first breakpoint to the last that meet each, with steps that grow after it.

    Twenty steps of 2 s and of 10 s follow each other; the others are alike, and of a minute at most.
    """
    times = [np.array(breakpoints[:1])]
    for start, end in pairwise(breakpoints):
        for step in (2.0, 10.0):
            if end - start > 40 * step:
                times.append(start + step * np.arange(1, 21))
                start = float(times[-1][-1])
        times.append(np.linspace(start, end, int(np.ceil((end - start) / 60.0)) + 1)[1:])
    return np.concatenate(times)

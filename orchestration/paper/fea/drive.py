"""What acts on the body over time: convection, ambient, and the temperature or heat flow at the shaft."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError

Array = NDArray[np.float64]


class Series(Protocol):
    """A value over time, seen from within one step so that a jump at the step's end is not felt early."""

    def within(self, start: float, step: float, fraction: float) -> float:
        """Value at `start + fraction * step` as the step from `start` of length `step` [s] sees it."""
        ...


@dataclass(frozen=True)
class Smooth:
    """A continuous function of time [s]; a plain number is a constant."""

    value: float | Callable[[float], float]

    def within(self, start: float, step: float, fraction: float) -> float:
        """Evaluate the function."""
        return float(self.value(start + fraction * step) if callable(self.value) else self.value)


@dataclass(frozen=True)
class Held:
    """Samples that hold until the next one; time steps have to end at the samples' times.

    Parameters
    ----------
    times : increasing [s]; the first value also holds before the first time
    values : one for each time
    """

    times: Sequence[float]
    values: Sequence[float]

    def __post_init__(self) -> None:
        if len(self.times) != len(self.values) or not len(self.times):
            raise InputError(
                f"held series: {len(self.times)} times and {len(self.values)} values; give as many of each"
            )
        if np.any(np.diff(self.times) <= 0):
            raise InputError("held series: times do not increase; sort them and remove repeated ones")

    def within(self, start: float, step: float, fraction: float) -> float:
        """Return the sample that holds in the middle of the step."""
        index = int(np.searchsorted(self.times, start + 0.5 * step, side="right")) - 1
        return float(self.values[max(index, 0)])


@dataclass(frozen=True)
class Sampled:
    """Samples with straight lines between them, constant beyond both ends; times [s] increase."""

    times: Sequence[float]
    values: Sequence[float]

    def within(self, start: float, step: float, fraction: float) -> float:
        """Interpolate."""
        return float(np.interp(start + fraction * step, self.times, self.values))


@dataclass(frozen=True)
class Drive:
    """Everything that acts from outside.

    `convection` [W/(m2.K)] on the surfaces named in `cooled` (None: all free surfaces), `ambient` [K], and
    either `temperature` [K] or `heat_flow` [W] at the heated boundary. With `radiation` the cooled surfaces
    exchange heat with the ambient by their materials' emissivity.
    """

    convection: Series
    ambient: Series
    temperature: Series | None = None
    heat_flow: Series | None = None
    radiation: bool = False
    cooled: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        if (self.temperature is None) == (self.heat_flow is None):
            raise InputError("drive: give either temperature or heat_flow at the heated boundary, not both")


@dataclass(frozen=True)
class TimeGrid:
    """Phases of equal steps: `phases` is a sequence of (number of steps, step size [s])."""

    phases: tuple[tuple[int, float], ...]
    start: float = 0.0
    _times: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        times = [np.array([self.start])]
        for count, step in self.phases:
            if count < 1 or step <= 0:
                raise InputError(f"time grid: {count} steps of {step} s; give at least one step above 0 s")
            times.append(times[-1][-1] + step * np.arange(1, count + 1))
        object.__setattr__(self, "_times", np.concatenate(times))

    @property
    def times(self) -> Array:
        """Start time and the end of every step [s]."""
        return self._times

    @property
    def steps(self) -> list[float]:
        """Size of every step [s], equal floats within a phase."""
        return [step for count, step in self.phases for _ in range(count)]


def graded_grid(
    breakpoints: Sequence[float], steps: Sequence[float] = (2.0, 10.0, 60.0), each: int = 20
) -> TimeGrid:
    """Grow the step after every breakpoint, where something jumps, and meet each breakpoint exactly.

    Parameters
    ----------
    breakpoints : times [s] of start, jumps and end, increasing
    steps : step sizes [s] to use one after the other; the last one fills the rest and shrinks to fit
    each : how many of every step but the last
    """
    phases: list[tuple[int, float]] = []
    for start, end in pairwise(breakpoints):
        left = end - start
        for step in steps[:-1]:
            if left > 2 * each * step:
                phases.append((each, step))
                left -= each * step
        count = int(np.ceil(left / steps[-1]))
        phases.append((count, left / count))
    return TimeGrid(tuple(phases), start=breakpoints[0])


#: An hour in 64 increments, as many as [1] V.B used; their sizes are not printed there.
PAPER_GRID = TimeGrid(((16, 7.5), (16, 30.0), (16, 60.0), (16, 127.5)))

"""Communication points as integer step counts, and runs that keep pace with real time."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from warmlink.fmus.errors import InputError


@dataclass(frozen=True)
class CommunicationPoints:
    """The points `start_time + i * step_size` in s, i = 0 ... count; no time is ever summed up.

    Where steps differ, `uneven` holds the times of all points, and `step_size` is the longest step.
    """

    start_time: float
    step_size: float
    count: int
    uneven: tuple[float, ...] = ()

    @classmethod
    def at(cls, times: Sequence[float], start_time: float, stop_time: float) -> CommunicationPoints:
        """Points at given times in s.

        InputError where they do not rise, or do not lead from the start time to the stop time.
        """
        steps = [end - begin for begin, end in pairwise(times)]
        if not steps or not all(0 < step < math.inf for step in steps):
            raise InputError("communication points: their times do not rise; give two or more that do, in s")
        if (times[0], times[-1]) != (start_time, stop_time):
            raise InputError(
                f"communication points: they lead from {times[0]:g} to {times[-1]:g} s, and the run from "
                f"{start_time:g} to {stop_time:g} s; give the same"
            )
        return cls(start_time, max(steps), len(steps), tuple(times))

    @classmethod
    def between(cls, start_time: float, stop_time: float, step_size: float) -> CommunicationPoints:
        """Lay out the points of a run, from times in s.

        InputError where a time is not finite, the step not above 0 s, the stop time before the start time, or
        the step does not divide the time between them (within rounding).
        """
        times = {"start time": start_time, "stop time": stop_time, "communication step size": step_size}
        for name, value in times.items():
            if not math.isfinite(value):
                raise InputError(f"{name}: {value} s is not a time; give a finite number of seconds")
        duration = stop_time - start_time
        if duration < 0:
            before = f"{stop_time:g} s lies before the start time {start_time:g} s"
            raise InputError(f"stop time: {before}; give a later one")
        told = f"communication step size: {step_size:g} s"
        if step_size <= 0:
            raise InputError(f"{told} is not positive; give a step above 0 s")
        if math.isinf(duration / step_size):
            raise InputError(f"{told} is too short for {duration:g} s; give a longer one")
        count = round(duration / step_size)
        if not _divides(step_size, duration):
            near = duration / max(count, 1)
            written = (f"{near:.{digits}g}" for digits in range(6, 18))
            proposed = next(text for text in written if _divides(float(text), duration))
            remedy = f"choose one that does, {proposed} s for instance"
            raise InputError(f"{told} does not divide the {duration:g} s to simulate; {remedy}")
        return cls(start_time, step_size, count)

    def time(self, point: int) -> float:
        """Give the time in s of a communication point."""
        return self.uneven[point] if self.uneven else self.start_time + point * self.step_size

    def step(self, point: int) -> float:
        """Give the length in s of the step that begins at a communication point."""
        return self.uneven[point + 1] - self.uneven[point] if self.uneven else self.step_size

    def first(self, count: int) -> CommunicationPoints:
        """The same points up to that many steps, or all."""
        count = min(count, self.count)
        return replace(self, count=count, uneven=self.uneven[: count + 1])

    def following(self, point: int) -> CommunicationPoints:
        """The same points from one of them on."""
        return replace(
            self, start_time=self.time(point), count=self.count - point, uneven=self.uneven[point:]
        )

    @property
    def stop_time(self) -> float:
        """Time in s of the last point."""
        return self.time(self.count)


def _divides(step_size: float, duration: float) -> bool:
    """Whether whole steps make up a duration, within rounding."""
    return abs(round(duration / step_size) * step_size - duration) <= 1e-9 * max(duration, step_size)


class StepClock:
    """Holds each communication point back until its time has come.

    The pace is in simulated seconds for each second of wall time. The `lag` is the largest delay of a point
    behind its time, in s of wall time.
    """

    def __init__(self, pace: float) -> None:
        self._pace = pace
        self._began = time.monotonic()
        self.lag = 0.0

    def wait(self, elapsed: float) -> None:
        """Wait until `elapsed` simulated seconds are due."""
        ahead = self._began + elapsed / self._pace - time.monotonic()
        if ahead > 0:
            time.sleep(ahead)
        else:
            self.lag = max(self.lag, -ahead)

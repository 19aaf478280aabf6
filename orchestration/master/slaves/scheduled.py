"""FMI 3.0 FMUs for scheduled execution as slaves: the master is the scheduler of their clocks."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Sequence
from ctypes import byref, c_double, c_int, c_uint, c_void_p
from pathlib import Path

from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.integration import MOST_EVENTS, at_end
from warmlink.orchestration.master.slaves.slave import Names, SlaveError
from warmlink.orchestration.master.slaves.versions import Fmi3Slave, resource_path

_CLOCK_UPDATE, _LOCK = ctypes.CFUNCTYPE(None, c_void_p), ctypes.CFUNCTYPE(None)
_CHANGED = 2  # fmi3IntervalChanged


class Fmi3ScheduledSlave(Fmi3Slave):
    """One instance of an FMI 3.0 FMU for scheduled execution (FMI 3.0 section 5).

    Periodic input clocks tick at their times, those of countdown when the FMU says so, both in a step that
    they lie in, its beginning included and its end not; at one time the order is that of their priorities.
    Triggered input clocks have nobody here to tick them, which is said.
    """

    plain_step = False

    def instantiate(self, name: bytes, token: bytes, resources: Path) -> int | None:
        """Instantiate; the callbacks live as long as this object."""
        self._asked_by_fmu = _CLOCK_UPDATE(lambda environment: None), _LOCK(lambda: None), _LOCK(lambda: None)
        given = name, token, resource_path(resources), False, False, None, self.log_callback()
        found: int | None = self.function("InstantiateScheduledExecution")(*given, *self._asked_by_fmu)
        return found

    def exit_initialization(self) -> None:
        """Leave initialization mode, and plan the first ticks."""
        super().exit_initialization()
        inputs = [v for v in self.variables.values() if v.causality == "input"]
        self._clocks = {v.value_reference: v.clock for v in inputs if v.clock is not None}
        self._periods, self._begun = dict[int, float](), self.time
        self._next = dict.fromkeys(self._clocks, math.inf)
        self._counts = dict.fromkeys(self._clocks, 0)
        for reference, clock in self._clocks.items():
            if clock.kind == "triggered":
                told = "is a triggered clock, which nothing ticks here"
                self.remarks.append(f"{self.name}.{clock.name}: {told}")
            elif clock.kind != "countdown":
                period = self._interval(reference)[0] if clock.interval is None else clock.interval
                if not period > 0:
                    told = f"the clock {clock.name} ticks every {period:g} s"
                    raise SlaveError(self.name, "error", self.time, told)
                self._periods[reference], self._next[reference] = period, self._begun + clock.shift
        self._count_down(self.time)

    def step(self, time: float, step_size: float) -> str | None:
        """Tick all clocks that are due in one communication step."""
        self.time, end = time, time + step_size
        self.note(under_way.STEPPING)
        for _ in range(MOST_EVENTS):
            now = min(self._next.values(), default=math.inf)
            if at_end(now, end):
                self.watch_step()
                return None
            self._tick(now)
        raise SlaveError(self.name, "error", time, f"has more than {MOST_EVENTS} ticks up to {now:.10g} s")

    def _tick(self, now: float) -> None:
        """Activate the partition of the clock that comes first at a time in s."""
        due = [reference for reference, time in self._next.items() if at_end(now, time)]
        first = min(due, key=lambda reference: self._clocks[reference].priority)
        self._counts[first] += 1
        later = self._begun + self._clocks[first].shift + self._counts[first] * self._periods.get(first, 0.0)
        self._next[first] = later if first in self._periods else math.inf
        self.ask("ActivateModelPartition", first, now)
        self._count_down(now)

    def _count_down(self, now: float) -> None:
        """Plan the ticks of the clocks whose countdown the FMU has begun."""
        for reference, clock in self._clocks.items():
            if clock.kind == "countdown":
                interval, changed = self._interval(reference)
                if changed == _CHANGED:
                    self._next[reference] = now + interval

    def _interval(self, reference: int) -> tuple[float, int]:
        """Give a clock's interval in s as the FMU tells it, and how it qualifies that."""
        interval, qualifier = c_double(), c_int()
        self.ask("GetIntervalDecimal", byref(c_uint(reference)), 1, byref(interval), byref(qualifier))
        return interval.value, qualifier.value

    def set_input_derivatives(self, names: Names, order: int, values: Sequence[float]) -> None:
        """Refuse: inputs are held during a step."""
        raise SlaveError(self.name, "error", self.time, "takes no derivatives of inputs")

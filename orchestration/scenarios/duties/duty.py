"""What drives a system: duty cycles, which say what a joint is asked to do, segment by segment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.component.table import EARLY, RecordedTable
from warmlink.fmus.duty_cycle.component import COMPONENT, SEGMENTS
from warmlink.fmus.duty_cycle.equations import DEMANDS
from warmlink.fmus.errors import InputError
from warmlink.orchestration.machine.machine import DUTY
from warmlink.orchestration.system.model import StartValues

NO_PAD, PAD_POWER, PAD_TEMPERATURE = 0, 1, 2
"""Values of `pad_mode`."""

MOST_SEGMENTS = 100_000
"""Segments that a duty cycle may be drawn or ramped into."""

UNITS = {"duration": "s", **{each.name: each.unit for each in COMPONENT.outputs if each.name != "pad_mode"}}
"""SI unit of every quantity of a segment."""


@dataclass(frozen=True)
class Segment:
    """Constant demands over a time: s, rad/s, N.m, K, pad mode, K, W."""

    duration: float
    speed: float = 0.0
    torque: float = 0.0
    ambient_temperature: float = ROOM_TEMPERATURE
    pad_mode: int = NO_PAD
    pad_temperature: float = ROOM_TEMPERATURE
    pad_power: float = 0.0

    @classmethod
    def with_pad(
        cls,
        duration: float,
        pad_temperature: float,
        speed: float = 0.0,
        torque: float = 0.0,
        ambient_temperature: float = ROOM_TEMPERATURE,
    ) -> Segment:
        """Segment during which a pad is held at a temperature in K."""
        return cls(duration, speed, torque, ambient_temperature, PAD_TEMPERATURE, pad_temperature)

    @property
    def pad(self) -> float:
        """Temperature in K at which a pad is held; NaN where none is."""
        return self.pad_temperature if self.pad_mode == PAD_TEMPERATURE else float("nan")


def padded(temperature: float | None, power: float | None) -> dict[str, Any]:
    """What of a segment a pad's temperature in K or power in W sets; InputError where both are given."""
    if temperature is not None and power is not None:
        raise InputError("pad_temperature and pad_power exclude each other; give one")
    if temperature is not None:
        return {"pad_mode": PAD_TEMPERATURE, "pad_temperature": temperature}
    return {"pad_mode": NO_PAD} if power is None else {"pad_mode": PAD_POWER, "pad_power": power}


def length(segments: Sequence[Segment]) -> float:
    """Duration of all segments in s."""
    return sum(segment.duration for segment in segments)


def demands_at(segments: Sequence[Segment], times: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Demands by name at times in s, shape (times,) each, in SI units; the last segment holds.

    The pad temperature is NaN where no pad is held at one.
    """
    ends = np.cumsum([segment.duration for segment in segments])
    which = np.minimum(np.searchsorted(ends, times + EARLY, side="right"), len(segments) - 1)
    table = np.array([(s.speed, s.torque, s.pad, s.ambient_temperature) for s in segments])[which]
    return dict(zip(("speed", "torque", "pad_temperature", "ambient_temperature"), table.T, strict=True))


@dataclass(frozen=True)
class Drive:
    """What drives a system up to a stop time in s: a duty cycle, or a program of an arm.

    It has a name, a title of a line and a reason why it is as it is; `remarks` say what was taken for granted
    where a file did not say it.
    """

    name: str
    title: str
    reason: str
    stop_time: float
    remarks: tuple[str, ...] = field(default=(), kw_only=True)

    def until(self, stop_time: float) -> Drive:
        """The same with another stop time in s."""
        return replace(self, stop_time=stop_time)

    def start_values(self) -> StartValues:
        """Start values of the instances that drive the others."""
        raise NotImplementedError

    @property
    def tables(self) -> Mapping[str, RecordedTable]:
        """Tables that instances play in place of segments, by the instance."""
        return {}

    def unrolled(self) -> tuple[Segment, ...]:
        """Segments of one joint up to the stop time; raises InputError where they are too many."""
        raise NotImplementedError


@dataclass(frozen=True)
class Duty(Drive):
    """A duty cycle: segments one after the other; the last one holds, or all begin again with `repeat`."""

    segments: tuple[Segment, ...]
    repeat: bool = False

    def unrolled(self) -> tuple[Segment, ...]:
        """Segments up to the stop time, repeated as in a run; raises InputError where they are too many."""
        cycles = self.stop_time / length(self.segments) if self.repeat else 1.0
        check_segments(cycles * len(self.segments), self.name)
        found: list[Segment] = []
        left, rounding = self.stop_time, 1e-9 * self.stop_time
        while left > rounding:
            for i, part in enumerate(self.segments):
                last = not self.repeat and i + 1 == len(self.segments)  # which holds to the end
                lasts = left if last else min(part.duration, left)
                left -= lasts
                segment = replace(part, duration=lasts)
                if found and replace(found[-1], duration=lasts) == segment:
                    found[-1] = replace(segment, duration=found[-1].duration + lasts)
                elif lasts > rounding:
                    found.append(segment)
        return tuple(found)

    def start_values(self) -> StartValues:
        """Start values of the instance `duty`; raises as `component_parameters`."""
        return {DUTY: self.component_parameters}

    @cached_property
    def component_parameters(self) -> dict[str, float | bool]:
        """Parameters of the DutyCycle component by scalar name; InputError where it has too few segments."""
        if len(self.segments) > SEGMENTS:
            raise InputError(
                f"{self.name}: {len(self.segments)} segments are more than the {SEGMENTS} that the DutyCycle "
                "component holds; use fewer and longer ones, or repeat, or write them as rows of a CSV file, "
                "which may have any number"
            )
        values: dict[str, float | bool] = {"repeat": self.repeat}
        unused = [Segment(0.0)] * (SEGMENTS - len(self.segments))
        for i, segment in enumerate([*self.segments, *unused], start=1):
            values[f"duration[{i}]"] = segment.duration
            for name in DEMANDS:
                values[f"segment_{name}[{i}]"] = getattr(segment, name)
        return values


IDLE = Duty("idle", "idle", "", 1.0, (Segment(1.0),))
"""A duty cycle that demands nothing."""


@dataclass(frozen=True)
class Recorded(Drive):
    """A recorded duty: a table of any length, whose last row holds; each column held or linear."""

    table: RecordedTable

    def until(self, stop_time: float) -> Self:
        """The same with another stop time in s; a remark says where that is after the last row."""
        told = tuple(each for each in self.remarks if not each.endswith(_HOLDS))
        if self.table.ends_before(stop_time):
            told += (f"{self.name} ends at {self.table.end:g} s{_HOLDS}",)
        return replace(self, stop_time=stop_time, remarks=told)

    @cached_property
    def begins(self) -> NDArray[np.intp]:
        """Rows before the stop time that differ from the one before, from 0."""
        changes = np.zeros(self.table.times.size, dtype=bool)
        changes[0] = True
        for each in self.table.columns:
            changes[1:] |= each[1:] != each[:-1] if each.size > 1 else False
        begins: NDArray[np.intp] = np.flatnonzero(changes & (self.table.times < self.stop_time))
        return begins

    def start_values(self) -> StartValues:
        """No start values: the table says it all."""
        return {}

    @property
    def tables(self) -> Mapping[str, RecordedTable]:
        """The table, which the instance `duty` plays."""
        return {DUTY: self.table}

    def unrolled(self) -> tuple[Segment, ...]:
        """A segment for each row that differs from the one before, up to the stop time.

        InputError where they are too many, or a column is linear between rows.
        """
        if self.table.linear:
            told = f"{', '.join(sorted(self.table.linear))} is linear between rows, as no segment is"
            raise InputError(f"{self.name}: {told}; have it held")
        table, begins = self.table, self.begins
        check_segments(begins.size, self.name)
        columns = [each[begins] if each.size > 1 else each for each in table.columns]
        values = np.column_stack([np.broadcast_to(each, begins.shape) for each in columns])
        lasting = np.diff([*table.times[begins], self.stop_time]).tolist()
        return tuple(
            Segment(
                **{**dict(zip(table.names, row, strict=True)), "duration": lasts, "pad_mode": round(mode)}
            )
            for row, mode, lasts in zip(
                values.tolist(), values[:, table.names.index("pad_mode")], lasting, strict=True
            )
        )


@dataclass(frozen=True)
class RecordedSegments(Duty):
    """Segments of a recorded duty of so few rows that DutyCycle holds them, all but the last row."""

    whole: Recorded = field(kw_only=True, repr=False, compare=False)

    @classmethod
    def of(cls, whole: Recorded) -> Drive:
        """A recorded duty up to its stop time as segments; as it is where DutyCycle holds fewer."""
        if whole.table.linear or whole.begins.size > SEGMENTS:
            return whole
        told = whole.name, whole.title, whole.reason, whole.stop_time
        return cls(*told, whole.unrolled(), remarks=whole.remarks, whole=whole)

    def until(self, stop_time: float) -> Drive:
        """The same with another stop time in s, after the last row with a segment that holds that row."""
        return self.of(self.whole.until(stop_time))


_HOLDS = "; its last row holds from then on"


def check_segments(count: float, where: str) -> None:
    """Refuse a duty cycle of too many segments; raises InputError."""
    if count > MOST_SEGMENTS:
        raise InputError(
            f"{where}: makes up to {count:.3g} segments, and {MOST_SEGMENTS} are the most; make them longer"
        )

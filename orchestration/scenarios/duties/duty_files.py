"""Duty cycles in TOML files: those that warmlink ships, and anybody's.

A duty cycle file holds `title`, `reason`, `stop_time`, perhaps `repeat`, and either `[[segment]]` tables or
one `[random]` table from whose seed the segments are drawn. A segment has `duration`, `speed`, `torque`,
`ambient_temperature` and, for a heating pad, `pad_temperature` or `pad_power`; `ambient_temperature_end` and
`steps` make it a ramp. Values are strings with a unit, as `"3.43 rad/s"`; what is left out is 0, or 22 degC.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.scenarios.duties.duty import (
    MOST_SEGMENTS,
    NO_PAD,
    PAD_POWER,
    PAD_TEMPERATURE,
    Duty,
    Segment,
    check_segments,
)
from warmlink.orchestration.scenarios.duties.duty_csv import read_csv
from warmlink.orchestration.scenarios.entries import Bounds, Flag, Quantity, Text, Whole
from warmlink.orchestration.scenarios.written import TABLE, read_table
from warmlink.orchestration.text_files import read_toml, shortened

LIBRARY = Path(__file__).parents[1] / "duty_cycles"

SHORTEST_DRAWN = 1.0
"""Shortest segment in s that can be drawn, since drawn ones last whole seconds."""

MOST_SEED = 2**63 - 1


@dataclass(frozen=True)
class SegmentTable:
    """One segment of a duty cycle."""

    __pydantic_config__ = TABLE

    duration: Annotated[float, Quantity("s", positive=True)]
    speed: Annotated[float, Quantity("rad/s", least=0)] = 0.0
    torque: Annotated[float, Quantity("N.m", least=0)] = 0.0
    ambient_temperature: Annotated[float, Quantity("K", least=0)] = ROOM_TEMPERATURE
    ambient_temperature_end: Annotated[float | None, Quantity("K", least=0)] = None
    steps: Annotated[int, Whole(1, MOST_SEGMENTS)] = 10
    pad_temperature: Annotated[float | None, Quantity("K", least=0)] = None
    pad_power: Annotated[float | None, Quantity("W", least=0)] = None

    def __post_init__(self) -> None:
        if self.pad_temperature is not None and self.pad_power is not None:
            raise InputError("pad_temperature and pad_power exclude each other; give one")

    def segments(self) -> Iterator[Segment]:
        """The segment, or the steps of its ramp."""
        end, steps = self.ambient_temperature_end, self.steps
        if end is None:
            end, steps = self.ambient_temperature, 1
        held, heated = self.pad_temperature, self.pad_power
        for i in range(steps):
            share = (i + 0.5) / steps
            yield Segment(
                self.duration / steps,
                self.speed,
                self.torque,
                self.ambient_temperature + share * (end - self.ambient_temperature),
                PAD_TEMPERATURE if held is not None else PAD_POWER if heated is not None else NO_PAD,
                ROOM_TEMPERATURE if held is None else held,
                heated or 0.0,
            )


@dataclass(frozen=True)
class RandomTable:
    """Bounds between which segments are drawn evenly until the stop time is filled."""

    __pydantic_config__ = TABLE

    seed: Annotated[int, Whole(0, MOST_SEED)]
    duration: Annotated[tuple[float, float], Bounds("s", SHORTEST_DRAWN)]
    speed: Annotated[tuple[float, float], Bounds("rad/s")]
    torque: Annotated[tuple[float, float], Bounds("N.m")]

    def segments(self, stop_time: float, where: str) -> Iterator[Segment]:
        """Segments until the stop time in s; raises InputError where there may be too many."""
        check_segments(stop_time / self.duration[0], where)
        generator = np.random.default_rng(self.seed)
        time = 0.0
        while time < stop_time:
            # Whole seconds, so that the segments fall on communication points.
            duration = float(round(generator.uniform(*self.duration)))
            speed, torque = (round(float(generator.uniform(*each)), 3) for each in (self.speed, self.torque))
            yield Segment(duration, speed, torque)
            time += duration


@dataclass(frozen=True, kw_only=True)
class DutyTables:
    """Segments, or bounds between which they are drawn."""

    title: Annotated[str | None, Text()] = None
    reason: Annotated[str, Text()] = ""
    repeat: Annotated[bool, Flag()] = False
    segment: tuple[SegmentTable, ...] = ()
    random: RandomTable | None = None

    def check(self) -> None:
        """Raise InputError where there are none of them, or both."""
        if bool(self.segment) == (self.random is not None):
            raise InputError("give either [[segment]] tables or one [random] table")

    def laid_out(self, name: str, stop_time: float) -> Duty:
        """The duty cycle of a stop time in s; raises InputError where it has too many segments."""
        if self.random is not None:
            segments = tuple(self.random.segments(stop_time, f"{name}: random.duration"))
        else:
            ramps = (1 if each.ambient_temperature_end is None else each.steps for each in self.segment)
            check_segments(sum(ramps), name)
            segments = tuple(piece for each in self.segment for piece in each.segments())
        title = name if self.title is None else self.title
        return Duty(name, title, self.reason.strip(), stop_time, segments, self.repeat)


@dataclass(frozen=True, kw_only=True)
class DutyFile(DutyTables):
    """A duty cycle: segments, or bounds between which they are drawn."""

    __pydantic_config__ = TABLE

    stop_time: Annotated[float, Quantity("s", positive=True)]

    def __post_init__(self) -> None:
        self.check()


def names() -> list[str]:
    """Names of the duty cycles in the library."""
    return sorted(path.stem for path in LIBRARY.glob("*.toml"))


def load(source: str | Path) -> Duty:
    """Duty cycle from the library by name, or from a .toml or .csv file by path.

    Raises
    ------
    InputError
        There is no such duty cycle, or its file cannot be used.
    """
    path, name = Path(source), str(source)
    if path.suffix == ".csv":
        return read_csv(path)
    if path.suffix != ".toml":
        if name not in names():
            raise InputError(f"{shortened(name)}: no such duty cycle; {instead(name, names())}")
        path = LIBRARY / f"{name}.toml"
    return parsed(read_toml(path, "give an existing .toml or .csv"), path.stem)


def parsed(given: Mapping[str, Any], name: str) -> Duty:
    """Duty cycle from the tables of a file.

    Raises
    ------
    InputError
        Something is missing, misspelt or out of range.
    """
    read = read_table(DutyFile, given, name)
    return read.laid_out(name, read.stop_time)

"""Duty cycles in files: TOML, as those that warmlink ships, and recorded ones in CSV.

A duty cycle in TOML has `title`, `reason`, `stop_time`, perhaps `repeat`, and either `[[segment]]` tables or
one `[random]` table from whose seed the segments are drawn. A segment has `duration`, `speed`, `torque`,
`ambient_temperature` and, for a heating pad, `pad_temperature` or `pad_power`; `ambient_temperature_end` and
`steps` make it a ramp. Values are strings with a unit, as `"3.43 rad/s"`; what is left out is 0, or 22 degC.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np

from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.scenarios.duties.duty import (
    MOST_SEGMENTS,
    Drive,
    Duty,
    Segment,
    check_segments,
    padded,
)
from warmlink.orchestration.text_files import read_toml, shortened
from warmlink.orchestration.written.entries import Bounds, Flag, Quantity, Text, Whole
from warmlink.orchestration.written.tables import Table, read_table

RECORDED_IN = (".csv", ".parquet", ".pq")
"""Endings of files that hold a recorded duty."""

COLUMNS = ("time", "speed", "torque", "ambient_temperature", "pad_temperature", "pad_power")
"""What a column of a recorded duty may be."""

LIBRARY = Path(__file__).parents[1] / "duty_cycles"

SHORTEST_DRAWN = 1.0
"""Shortest segment in s that can be drawn, since drawn ones last whole seconds."""

MOST_SEED = 2**63 - 1

Row = tuple[Segment, ...]
"""What each joint does at the same time; a cell has one joint."""


def durations(
    generator: np.random.Generator, lasting: tuple[float, float], stop_time: float, where: str
) -> Iterator[float]:
    """Draw durations in s between the shortest and the longest until a stop time in s is filled.

    InputError where there may be too many of the shortest, or none fits; `where` is its name.
    """
    check_segments(stop_time / lasting[0], where)
    # To within the rounding of a unit: 2.05 min are 122.99999999999999 s.
    bounds = math.ceil(lasting[0] - 1e-9), math.floor(lasting[1] + 1e-9)
    if bounds[0] > bounds[1]:
        between = " and ".join(f"{each:g} s" for each in lasting)
        raise InputError(f"{where}: there is no whole number of seconds between {between}; widen the bounds")
    time = 0.0
    while time < stop_time:
        # Whole seconds, so that the segments fall on communication points.
        duration = float(round(generator.uniform(*bounds)))
        yield duration
        time += duration


@dataclass(frozen=True)
class SegmentTable(Table):
    """One segment of a duty cycle."""

    duration: Annotated[float, Quantity("s", positive=True)]
    speed: Annotated[float, Quantity("rad/s", least=0)] = 0.0
    torque: Annotated[float, Quantity("N.m", least=0)] = 0.0
    ambient_temperature: Annotated[float, Quantity("K", least=0)] = ROOM_TEMPERATURE
    ambient_temperature_end: Annotated[float | None, Quantity("K", least=0)] = None
    steps: Annotated[int, Whole(1, MOST_SEGMENTS)] = 10
    pad_temperature: Annotated[float | None, Quantity("K", least=0)] = None
    pad_power: Annotated[float | None, Quantity("W", least=0)] = None

    def __post_init__(self) -> None:
        padded(self.pad_temperature, self.pad_power)

    @property
    def most(self) -> int:
        """One, or the steps of its ramp."""
        return 1 if self.ambient_temperature_end is None else self.steps

    def rows(self, stop_time: float, where: str) -> Iterator[Row]:
        """The segment, or the steps of its ramp."""
        end, steps = self.ambient_temperature_end, self.most
        rise = 0.0 if end is None else end - self.ambient_temperature
        pad = padded(self.pad_temperature, self.pad_power)
        for i in range(steps):
            ambient = self.ambient_temperature + (i + 0.5) / steps * rise
            yield (Segment(self.duration / steps, self.speed, self.torque, ambient, **pad),)


@dataclass(frozen=True)
class RandomTable(Table):
    """Bounds between which segments are drawn evenly until the stop time is filled."""

    seed: Annotated[int, Whole(0, MOST_SEED)]
    duration: Annotated[tuple[float, float], Bounds("s", least=SHORTEST_DRAWN)]
    speed: Annotated[tuple[float, float], Bounds("rad/s")]
    torque: Annotated[tuple[float, float], Bounds("N.m")]

    def rows(self, stop_time: float, where: str) -> Iterator[Row]:
        """Segments that are drawn until a stop time in s."""
        generator = np.random.default_rng(self.seed)
        for duration in durations(generator, self.duration, stop_time, f"{where}.duration"):
            speed, torque = (round(float(generator.uniform(*each)), 3) for each in (self.speed, self.torque))
            yield (Segment(duration, speed, torque),)


@dataclass(frozen=True, kw_only=True)
class RowsTables(Table):
    """Segments of one joint or of several, or bounds between which they are drawn.

    A table gives its `rows`, and the `most` that a segment has.
    """

    title: Annotated[str | None, Text()] = None
    reason: Annotated[str, Text()] = ""
    repeat: Annotated[bool, Flag()] = False
    segment: tuple[Any, ...] = ()
    random: Any = None

    def __post_init__(self) -> None:
        if bool(self.segment) == (self.random is not None):
            raise InputError("give either [[segment]] tables or one [random] table")

    def duties(self, name: str, stop_time: float, called: Sequence[str]) -> tuple[Duty, ...]:
        """Duty cycle of each joint up to a stop time in s; raises InputError where segments are too many.

        `called` are the names of the duty cycles, `name` that of the file.
        """
        if self.random is None:
            check_segments(sum(each.most for each in self.segment), name)
        tables = self.segment if self.random is None else (self.random,)
        rows = [row for each in tables for row in each.rows(stop_time, f"{name}: random")]
        title, reason = name if self.title is None else self.title, self.reason.strip()
        return tuple(
            Duty(each, title, reason, stop_time, segments, self.repeat)
            for each, segments in zip(called, zip(*rows, strict=True), strict=True)
        )


@dataclass(frozen=True, kw_only=True)
class DutyTables(RowsTables):
    """Segments, or bounds between which they are drawn."""

    segment: tuple[SegmentTable, ...] = ()
    random: RandomTable | None = None


@dataclass(frozen=True, kw_only=True)
class DutyFile(DutyTables):
    """A duty cycle: segments, or bounds between which they are drawn."""

    stop_time: Annotated[float, Quantity("s", positive=True)]


def names() -> list[str]:
    """Names of the duty cycles in the library."""
    return sorted(path.stem for path in LIBRARY.glob("*.toml"))


def load(
    source: str | Path, linear: Sequence[str] = (), columns: Mapping[str, str] = MappingProxyType({})
) -> Drive:
    """Duty cycle from the library by name, or from a .toml, .csv or .parquet file by path.

    `linear` names the columns of a recorded one that are so between its rows, `columns` says what its own
    names are. Raises InputError if there is no such duty cycle, its file cannot be used, or it has no
    columns.
    """
    path, name = Path(source), str(source)
    if path.suffix.lower() in RECORDED_IN:
        from warmlink.orchestration.scenarios.duties.recorded import read_recorded

        return read_recorded(path, linear, columns)
    for key, given in (("linear", linear), ("columns", columns)):
        if given:
            told = f"{key}: {shortened(name)} has segments and no columns"
            raise InputError(f"{told}; name a recorded duty (CSV, Parquet), or leave it out")
    if path.suffix.lower() != ".toml":
        if name not in names():
            raise InputError(f"{shortened(name)}: no such duty cycle; {instead(name, names())}")
        path = LIBRARY / f"{name}.toml"
    return parsed(read_toml(path, "give an existing .toml, .csv or .parquet"), path.stem)


def parsed(given: Mapping[str, Any], name: str) -> Duty:
    """Duty cycle from the tables of a file; raises as `load`."""
    read = read_table(DutyFile, given, name)
    return read.duties(name, read.stop_time, (name,))[0]

"""Causes that a person declares for a system of their own, in a file `causes.toml`.

```toml
[[cause]]
name = "bearing_preload"
sentence = "The bearing is preloaded more than assumed."
check = "Measure the run-down time."
frees = ["spindle.friction"]                       # parameters that take one common value
between = ["0.2 N.m", "5 N.m"]
[[cause]]
name = "motor_heats_column"
sentence = "The motor heats the column through its flange."
check = "Put a thermometer on the flange."
adds = { conductance = "W/K", from = "motor.shaft_temperature", to = "column.base_temperature",
         into = "column.heat_flow" }
between = ["0 W/K", "5 W/K"]
[[cause]]
name = "slow_sensor"
sentence = "The table's thermometer follows late."
check = "Exchange it with another one."
reading = { of = "table.temperature", lag = "s" }
between = ["0 s", "300 s"]
```
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from warmlink.fmus.component import Scalar
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.diagnosis.causes.catalogue import Cause
from warmlink.orchestration.scenarios.entries import Entry, Names, Text, Value
from warmlink.orchestration.scenarios.overrides import to_si
from warmlink.orchestration.scenarios.quantity import converter, quantity
from warmlink.orchestration.scenarios.written import TABLE, read_table
from warmlink.orchestration.text_files import read_toml, shown

READING = {"lag": "s", "offset": "", "scale": "1", "stem": "1", "clock": "s"}
"""Faults of a reading with their SI units; an offset has that of the reading."""

WITH = "with:"
_COURSES = {"constant": "heat", "ramp": "heat_rate", WITH: "heat_per_speed"}
"""Courses of a source of heat, and the parameter of a heat path that stands for each."""

_WITH_FROM: Any = {**TABLE, "alias_generator": lambda name: "from" if name == "giver" else name}
"""Settings of a table with an entry `from`, which Python keeps for itself."""

Ends = Annotated[str | None, Text("column.heat_flow")]
Unit = Annotated[str | None, Text("W/K")]


@dataclass(frozen=True)
class Pair(Entry):
    """Two values with units, as they are written: the cause says of what unit they are."""

    def _read(self, value: Any) -> tuple[str | float, str | float]:
        if not isinstance(value, list) or len(value) != 2:
            raise InputError(f'{shown(value)} is no pair of bounds; write ["0 W/K", "5 W/K"]')
        return Value()._read(value[0]), Value()._read(value[1])

    def _schema(self) -> dict[str, Any]:
        items = Value()._schema()
        return {"type": "array", "items": items, "minItems": 2, "maxItems": 2, "examples": [["0", "5 W/K"]]}


@dataclass(frozen=True, kw_only=True)
class AddsTable:
    """A heat path: a conductance between two temperatures, or a source of heat, into a heat flow."""

    __pydantic_config__ = _WITH_FROM

    into: Annotated[str, Text("column.heat_flow")]
    conductance: Unit = None
    giver: Annotated[str | None, Text("motor.shaft_temperature")] = None
    to: Annotated[str | None, Text("column.base_temperature")] = None
    out_of: Ends = None
    heat: Unit = None
    course: Annotated[str, Text(f"{WITH}spindle.speed")] = "constant"

    def __post_init__(self) -> None:
        if (self.conductance is None) == (self.heat is None):
            raise InputError('needs either conductance = "W/K" or heat = "W"')
        if self.conductance is not None and (self.giver is None or self.to is None):
            raise InputError("a conductance lies between two temperatures; give both as from and to")
        if self.course not in _COURSES and not self.course.startswith(WITH):
            raise InputError(f"course: {self.course!r} is none; give constant, ramp or {WITH}spindle.speed")

    @property
    def parameter(self) -> str:
        """Parameter of the heat path that the cause frees."""
        course = WITH if self.course.startswith(WITH) else self.course
        return "conductance" if self.heat is None else _COURSES[course]

    @property
    def sources(self) -> dict[str, str]:
        """Output that feeds each input of the heat path."""
        ends = {"from_temperature": self.giver, "to_temperature": self.to}
        if self.heat is not None and self.course.startswith(WITH):
            ends["speed"] = self.course.removeprefix(WITH)
        return {name: end for name, end in ends.items() if end is not None}

    @property
    def totals(self) -> dict[str, str]:
        """Input that each end of the heat path goes before, `to` or `from`."""
        return {"to": self.into, **({} if self.out_of is None else {"from": self.out_of})}


@dataclass(frozen=True, kw_only=True)
class ReadingTable:
    """One fault of the reading of an output: lag, offset, scale, stem conduction or clock, and its unit."""

    __pydantic_config__ = TABLE

    of: Annotated[str, Text("table.temperature")]
    lag: Unit = None
    offset: Unit = None
    scale: Unit = None
    stem: Unit = None
    clock: Unit = None

    def __post_init__(self) -> None:
        if len(self._faults) != 1:
            raise InputError(f'needs one of {", ".join(READING)}, with its unit, as lag = "s"')

    @property
    def fault(self) -> str:
        """The fault."""
        return self._faults[0]

    @property
    def _faults(self) -> list[str]:
        return [fault for fault in READING if getattr(self, fault) is not None]


@dataclass(frozen=True, kw_only=True)
class CauseTable:
    """A cause: parameters that it frees, a heat path that it adds, or a fault of a reading."""

    __pydantic_config__ = TABLE

    name: Annotated[str, Text("bearing_preload")]
    sentence: Annotated[str, Text("The bearing is preloaded more than assumed.")]
    check: Annotated[str, Text("Measure the run-down time.")]
    between: Annotated[tuple[str | float, str | float], Pair()]
    looks_like: Annotated[str, Text("warmer at speed")] = "as the sentence says"
    frees: Annotated[tuple[str, ...], Names("spindle.friction")] = ()
    adds: AddsTable | None = None
    reading: ReadingTable | None = None

    def __post_init__(self) -> None:
        if len([each for each in (self.frees, self.adds, self.reading) if each]) != 1:
            raise InputError(f"{self.name}: needs one of frees, adds and reading")
        if not self.name.replace("_", "").isalnum():
            raise InputError(f"{self.name!r} is no name; use letters, digits and underscores")


@dataclass(frozen=True)
class CausesFile:
    """Causes that a person declares for a system of their own."""

    __pydantic_config__ = TABLE

    cause: tuple[CauseTable, ...]

    def __post_init__(self) -> None:
        names = [each.name for each in self.cause]
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"two causes are called {name}; rename one")

    @property
    def paths(self) -> dict[str, AddsTable]:
        """Heat paths by the name of their cause."""
        return {each.name: each.adds for each in self.cause if each.adds is not None}


def read_causes(path: Path) -> CausesFile:
    """Read a file of causes; raises InputError where something in it is missing, unknown or wrong."""
    return read_table(CausesFile, read_toml(path), path.name)


Declared = Callable[[str, str], Scalar]
"""Declaration of a variable of the system by name and place of use; raises InputError where there is none."""


def causes_of(
    file: CausesFile, declared: Declared, known: Mapping[str, float], measured: Mapping[str, str], where: str
) -> Iterator[Cause]:
    """Causes for a system.

    Parameters
    ----------
    file : what was declared
    declared : finds a variable of the system
    known : values of variables that the experiment gives, in SI
    measured : column by output that was measured
    where : name of the file

    Raises
    ------
    InputError
        A variable does not exist or was not measured, units do not fit, or bounds do not hold the value that
        the system has.
    """
    for table in file.cause:
        place = f"{where}: {table.name}"
        if table.reading is not None:
            yield _of_reading(table, table.reading, declared, measured, place)
        else:
            yield _of_plant(table, declared, known, place)


def _of_plant(table: CauseTable, declared: Declared, known: Mapping[str, float], place: str) -> Cause:
    frees, adds = table.frees, table.adds
    if adds is not None:
        frees = (f"{table.name}.{adds.parameter}",)
        # A source's unit is its own, whatever its course.
        unit = "W" if adds.conductance is None else "W/K"
        converter(adds.conductance or adds.heat or "W", unit, f"{place}.adds")
    scalars = [declared(name, f"{place}.frees") for name in frees]
    for scalar in scalars:
        if scalar.start is None:
            raise InputError(f"{place}.frees: {scalar.name} is an output; name a parameter")
    start = known.get(frees[0], scalars[0].start) if adds is None else 0.0
    lower, upper = (to_si(each, scalars[0], f"{place}.between") for each in table.between)
    return _bounded(table, frees, (lower, upper), float(start or 0.0), scalars[0].variable.unit, place)


def _of_reading(
    table: CauseTable, reading: ReadingTable, declared: Declared, measured: Mapping[str, str], place: str
) -> Cause:
    scalar = declared(reading.of, f"{place}.reading.of")
    if reading.of not in measured:
        known = instead(reading.of, list(measured))
        raise InputError(f"{place}.reading.of: no column of the runs is {reading.of}; {known}")
    unit = READING[reading.fault] or scalar.variable.unit
    converter(getattr(reading, reading.fault), unit, f"{place}.reading", difference=True)
    lower, upper = (quantity(each, unit, f"{place}.between", difference=True) for each in table.between)
    start = float(reading.fault == "scale")
    cause = _bounded(table, (reading.of, reading.fault), (lower, upper), start, unit, place)
    return replace(cause, kind="declared reading")


def _bounded(
    table: CauseTable,
    frees: tuple[str, ...],
    between: tuple[float, float],
    start: float,
    unit: str,
    place: str,
) -> Cause:
    lower, upper = between
    if not lower <= start <= upper or lower == upper:
        shown = "" if unit == "1" else f" {unit}"
        raise InputError(
            f"{place}.between: {lower:g} to {upper:g}{shown} does not contain {start:g}{shown}, the value "
            "without the cause; give a lower and an upper bound about it"
        )
    words = table.looks_like, table.check
    return Cause(table.name, table.sentence, frees, *between, *words, shown_unit=unit, declared=True)

"""Causes that a person declares for a system of their own, in a file as `warmlink init causes` writes it.

Each frees parameters (`frees`), adds a heat path (`adds`), or is a fault of a reading (`reading`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from warmlink.fmus.component import Scalar
from warmlink.fmus.errors import InputError
from warmlink.fmus.heat_path.component import COMPONENT as HEAT_PATH
from warmlink.fmus.names import instead
from warmlink.orchestration.diagnosis.causes.catalogue import Cause, Kind
from warmlink.orchestration.text_files import read_toml, shown
from warmlink.orchestration.written.entries import Names, Setting, Text, Value
from warmlink.orchestration.written.quantities import converter, quantity
from warmlink.orchestration.written.tables import Table, read_table

if TYPE_CHECKING:
    from warmlink.orchestration.fmu_store import FmuStore

READING = {"lag": "s", "offset": "", "scale": "1", "stem": "1", "clock": "s"}
"""Faults of a reading with their SI units; an offset has that of the reading."""

_COURSES = {"constant": "heat", "ramp": "heat_rate", "with": "heat_per_speed"}
"""Courses of a source of heat, and the parameter of a heat path that stands for each."""

_WITH_FROM: Any = {"extra": "forbid", "alias_generator": lambda name: "from" if name == "giver" else name}
"""Settings of a table with an entry `from`, which Python keeps for itself."""

Ends = Annotated[str | None, Text("column.heat_flow")]
Unit = Annotated[str | None, Text("W/K")]


@dataclass(frozen=True)
class Pair(Setting):
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
    course: Annotated[str, Text("with:spindle.speed")] = "constant"

    def __post_init__(self) -> None:
        if (self.conductance is None) == (self.heat is None):
            raise InputError('needs either conductance = "W/K" or heat = "W"')
        if self.conductance is not None and (self.giver is None or self.to is None):
            raise InputError("a conductance lies between two temperatures; give both as from and to")
        course, _, signal = self.course.partition(":")
        if course not in _COURSES or (course == "with") != bool(signal):
            raise InputError(
                f"course: {self.course!r} is not a course; give constant, ramp or with:spindle.speed"
            )

    @property
    def parameter(self) -> str:
        """Parameter of the heat path that the cause frees."""
        return "conductance" if self.heat is None else _COURSES[self.course.partition(":")[0]]

    @property
    def sources(self) -> dict[str, str]:
        """Output that feeds each input of the heat path."""
        speed = self.course.partition(":")[2]
        ends = {"from_temperature": self.giver, "to_temperature": self.to, "speed": speed}
        return {name: end for name, end in ends.items() if end}

    @property
    def totals(self) -> dict[str, str]:
        """Input that each end of the heat path goes before, `to` or `from`."""
        return {"to": self.into, **({"from": self.out_of} if self.out_of else {})}

    def fmu(self, store: FmuStore) -> Path:
        """FMU of a heat path, from a store."""
        return store.files({HEAT_PATH.name})[HEAT_PATH.name]


@dataclass(frozen=True, kw_only=True)
class ReadingTable(Table):
    """One fault of the reading of an output: lag, offset, scale, stem conduction or clock, and its unit."""

    of: Annotated[str, Text("table.temperature")]
    lag: Unit = None
    offset: Unit = None
    scale: Unit = None
    stem: Unit = None
    clock: Unit = None

    def __post_init__(self) -> None:
        if len(self.units) != 1:
            raise InputError(f'needs one of {", ".join(READING)}, with its unit, as lag = "s"')

    @property
    def units(self) -> dict[str, str]:
        """Unit by fault, of which there is one."""
        return {fault: unit for fault in READING if (unit := getattr(self, fault)) is not None}


@dataclass(frozen=True, kw_only=True)
class CauseTable(Table):
    """A cause: parameters that it frees, a heat path that it adds, or a fault of a reading."""

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
class CausesFile(Table):
    """Causes that a person declares for a system of their own."""

    cause: tuple[CauseTable, ...]

    def __post_init__(self) -> None:
        names = [each.name for each in self.cause]
        for name in (name for name in names if names.count(name) > 1):
            raise InputError(f"two causes are called {name}; rename one")

    @property
    def paths(self) -> dict[str, AddsTable]:
        """Heat paths by the name of their cause."""
        return {each.name: each.adds for each in self.cause if each.adds is not None}


def read_causes(path: Path) -> CausesFile:
    """Read a file of causes; raises InputError where something in it is missing, unknown or wrong."""
    return read_table(CausesFile, read_toml(path), path.name)


Declared = Callable[[str, str], Scalar]
"""Declaration of a variable of the system by name and place of use; raises InputError if there is none."""


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
        place, reading = f"{where}: {table.name}", table.reading
        frees, start, unit, temperature = (
            _freed(table, declared, known, place)
            if reading is None
            else _misread(reading, declared, measured, f"{place}.reading")
        )
        lower, upper = (
            quantity(each, unit, f"{place}.between", difference=not temperature) for each in table.between
        )
        of = "" if unit == "1" else f" {unit}"
        if not lower <= start <= upper or lower == upper:
            raise InputError(
                f"{place}.between: {lower:g} to {upper:g}{of} does not contain {start:g}{of}, the value "
                "without the cause; give a lower and an upper bound about it"
            )
        told = frees, lower, upper, table.looks_like, table.check
        kind: Kind = "plant" if reading is None else "declared reading"
        yield Cause(table.name, table.sentence, *told, shown_unit=unit, kind=kind, declared=True)


_Freed = tuple[tuple[str, ...], float, str, bool]
"""What a cause frees, the value without it in SI, its unit, and whether it is a temperature."""


def _freed(table: CauseTable, declared: Declared, known: Mapping[str, float], place: str) -> _Freed:
    frees, adds = table.frees, table.adds
    if adds is not None:
        frees = (f"{table.name}.{adds.parameter}",)
        # A source's unit is its own, whatever its course.
        unit = "W/K" if adds.heat is None else "W"
        converter(adds.conductance or adds.heat or unit, unit, f"{place}.adds")
    scalars = [declared(name, f"{place}.frees") for name in frees]
    for scalar in scalars:
        if scalar.start is None:
            raise InputError(f"{place}.frees: {scalar.name} is an output; name a parameter")
    first = scalars[0]
    start = 0.0 if adds else known.get(frees[0], first.start or 0.0)
    return frees, start, first.variable.unit, first.is_temperature


def _misread(reading: ReadingTable, declared: Declared, measured: Mapping[str, str], place: str) -> _Freed:
    scalar = declared(reading.of, f"{place}.of")
    if reading.of not in measured:
        known = instead(reading.of, list(measured))
        raise InputError(f"{place}.of: no column of the runs is {reading.of}; {known}")
    ((fault, given),) = reading.units.items()
    unit = READING[fault] or scalar.variable.unit
    converter(given, unit, place, difference=True)
    return (reading.of, fault), float(fault == "scale"), unit, False

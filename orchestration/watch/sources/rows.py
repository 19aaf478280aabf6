"""Cells of a source's rows as signals in SI, one row at a time, by the rules of `diagnose`.

What a cell means depends on its row alone, never on how many rows came at once: so a log says the same
through every source.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import NamedTuple

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.columns import Assignment
from warmlink.orchestration.diagnosis.data.options import ReadOptions
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.scenarios.logged.cells import MARKS, MOST_PLAUSIBLE, OVERRANGE
from warmlink.orchestration.scenarios.logged.layout import conversion_to, headings
from warmlink.orchestration.scenarios.logged.sheet import Place, Sheet
from warmlink.orchestration.system.units import Conversion

CORRECTION = "correction"
"""Name of a column that holds what the machine's controller took out."""

_EPOCH_UNITS = ((4e17, 1e-9), (4e14, 1e-6), (4e11, 1e-3), (0.0, 1.0))
"""Counts since 1970 from which on a number without a unit is one of ns, us, ms, s."""

_SWITCH = {"true": 1.0, "false": 0.0}
"""What loggers write of a switch, in small letters."""

Cells = Sequence[str | float | None]
"""One row as a source gives it: text or numbers in the order of the headers, None where there is nothing."""


class LoggedRow(NamedTuple):
    """One row in SI: time in s, inputs and readings by variable, NaN if there is none, and a correction."""

    time: float
    inputs: dict[str, float]
    readings: dict[str, float]
    correction: float


@dataclass(frozen=True)
class _Signal:
    """A column that is used: where it stands, what it is, and how its numbers become SI."""

    column: int
    variable: str
    conversion: Conversion
    least: float
    most: float

    @property
    def may_switch(self) -> bool:
        """Whether it may be on or off, as no temperature and no growth can."""
        return not math.isfinite(self.most)

    def si(self, number: float) -> float:
        """Value in SI; NaN where the number stands for "no reading"."""
        value = self.conversion.factor * number + self.conversion.offset
        marked = abs(number) in MARKS and not self.may_switch
        none = marked or abs(number) >= OVERRANGE or not self.least <= value <= self.most
        return math.nan if none else value


class RowReader:
    """Reads rows under one line of headers.

    Parameters
    ----------
    name : of the source, for sentences
    headers : as in a CSV file, `tip_temperature [degC]`
    rig : the machine
    told : units and names of columns that the user gave
    comma : whether the source writes a comma as decimal mark, unless the user says otherwise

    Attributes
    ----------
    inputs, readings : variables that are read, in the order of the columns
    names : name of the column of each variable
    unused : headers of columns that nothing is made of
    doubtful : cells so far that held something but no number

    Raises
    ------
    InputError
        A header does not fit, there is no time, or nothing is measured.
    """

    def __init__(
        self, name: str, headers: Sequence[str], rig: Rig, told: ReadOptions, comma: bool = False
    ) -> None:
        import pandas as pd

        own = [h for h in headers if _is_correction(h)]
        empty = pd.DataFrame({i: pd.Series(dtype=object) for i in range(len(headers))})
        sheet = Sheet(
            name,
            headings((list(headers), [None] * len(headers))),
            empty,
            told.decimal,
            bool(told.decimal),
            "",
        )
        named = dict.fromkeys(own, "")
        assigned = Assignment(sheet, rig, told, named, {})
        self._name, self._clock = name, assigned.time()[0]
        self._comma = told.decimal == "comma" or (comma and told.decimal != "point")
        self._seconds = self._time_unit(sheet)
        self._signals = [self._signal(sheet, place, rig) for place in assigned.signals()]
        self.inputs = tuple(s.variable for s in self._signals if s.variable in rig.externals)
        self.readings = tuple(s.variable for s in self._signals if s.variable not in rig.externals)
        self.names: Mapping[str, str] = {p.variable: p.name for p in assigned.signals()}
        self.unused = tuple(h for h in assigned.unused if h not in own)
        self.doubtful = 0
        self._correction = self._own(sheet, own)
        if not self.readings:
            raise InputError(
                f"{name}: no measured column is known; give at least one of {', '.join(rig.measurable)}, "
                f"and say which is which with {assigned.offers()}"
            )

    @property
    def has_correction(self) -> bool:
        """Whether the log holds what the machine's controller took out."""
        return self._correction is not None

    def _time_unit(self, sheet: Sheet) -> float | None:
        unit = self._clock.unit
        if unit is None or "%" in unit:
            return None
        return conversion_to(unit, "s", sheet.of(self._clock.column), difference=True)[0].factor

    @staticmethod
    def _signal(sheet: Sheet, place: Place, rig: Rig) -> _Signal:
        scalar = rig.scalar(place.variable, sheet.of(place.column))
        if place.variable not in rig.externals and scalar.start is not None:
            told = f"{place.variable} is neither an input nor an output; leave the column out"
            raise InputError(f"{sheet.of(place.column)}: {told}")
        si = scalar.variable.unit
        if place.unit is None:
            usual = "degC" if scalar.is_temperature else {"m": "um"}.get(si, si)
            say = argument("units", {place.name: usual})
            raise InputError(
                f"{sheet.of(place.column)} has no unit; head it '{place.name} [{usual}]', or give {say}"
            )
        where, apart = sheet.of(place.column), not scalar.is_temperature
        conversion, _ = conversion_to(place.unit, si, where, difference=apart)
        limited = scalar.is_temperature or scalar.variable.display == "um"
        least, most = MOST_PLAUSIBLE[si] if limited else (-math.inf, math.inf)
        return _Signal(place.column, place.variable, conversion, least, most)

    @staticmethod
    def _own(sheet: Sheet, own: Sequence[str]) -> _Signal | None:
        """The column of the machine's own correction, if there is one."""
        from warmlink.orchestration.scenarios.logged.layout import name_and_unit

        if not own:
            return None
        column, unit = list(sheet.headers).index(own[0]), name_and_unit(own[0])[1]
        if unit is None:
            raise InputError(f"{sheet.of(column)} has no unit; head it '{CORRECTION} [um]'")
        conversion, _ = conversion_to(unit, "m", sheet.of(column), difference=True)
        return _Signal(column, CORRECTION, conversion, *MOST_PLAUSIBLE["m"])

    def read(self, cells: Cells) -> LoggedRow | None:
        """LoggedRow of some cells; None if it has no time, or the line is not whole."""
        time = self._time(cells[self._clock.column]) if self._clock.column < len(cells) else math.nan
        if not math.isfinite(time):
            self.doubtful += 1
            return None
        values = {each.variable: self._value(cells, each) for each in self._signals}
        inputs = {name: values[name] for name in self.inputs}
        readings = {name: values[name] for name in self.readings}
        correction = math.nan if self._correction is None else self._value(cells, self._correction)
        return LoggedRow(time, inputs, readings, correction)

    def _value(self, cells: Cells, signal: _Signal) -> float:
        """A cell in SI; NaN where it is empty, or what it holds stands for no reading."""
        cell = cells[signal.column] if signal.column < len(cells) else None
        if cell is None or cell == "":
            return math.nan
        switched = _SWITCH.get(str(cell).strip().lower()) if signal.may_switch else None
        value = signal.si(self._number(cell) if switched is None else switched)
        self.doubtful += math.isnan(value)
        return value

    def _number(self, cell: str | float) -> float:
        if isinstance(cell, str):
            cell = cell.strip()
            cell = cell.replace(",", ".") if self._comma else cell
        try:
            return float(cell)
        except (ValueError, OverflowError):
            return math.nan

    def _time(self, cell: str | float | None) -> float:
        """Seconds: a number in its unit, or a date; of one without a unit those since 1970."""
        if cell is None:
            return math.nan
        number = self._number(cell)
        if math.isfinite(number):
            if self._seconds is not None:
                return number * self._seconds
            return number * next(factor for least, factor in _EPOCH_UNITS if abs(number) >= least)
        text, form = str(cell).strip(), self._clock.unit or ""
        try:
            when = datetime.strptime(text, form) if "%" in form else datetime.fromisoformat(text)
        except ValueError:
            return math.nan
        return (when if when.tzinfo else when.replace(tzinfo=UTC)).timestamp()


def _is_correction(header: str) -> bool:
    from warmlink.orchestration.scenarios.logged.layout import name_and_unit, plain

    return plain(name_and_unit(header)[0]) == CORRECTION

"""Times of a sheet in seconds from the first row: numbers, or what `dates.py` reads."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from typing import TYPE_CHECKING

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.scenarios.logged.cells import numbers
from warmlink.orchestration.scenarios.logged.dates import (
    HOUR,
    NoTimeError,
    as_written,
    seconds,
    written_seconds,
)
from warmlink.orchestration.scenarios.logged.layout import COUNT, NUMBER, conversion_to
from warmlink.orchestration.scenarios.logged.sheet import Place, Sheet
from warmlink.orchestration.text_files import shown

if TYPE_CHECKING:
    import pandas as pd

_BESIDE = 600.0
"""s by which two rows may be apart, between which an hour begins anew at the end of summer time."""

_WALL = re.compile(r"(?:(?P<day>\d{4}-\d\d-\d\d)|[\w./, -]+)[T ](?P<hour>\d\d?):\d\d(?::\d\d(?:\.\d+)?)?")
"""A date with the time of the day that a clock on the wall shows, without an offset from UTC."""

_SUNDAY = 6
"""Day of the week on which clocks are put forward."""

_EPOCHS = {
    "s": (1.0, 1e9, 4e9),
    "ms": (1e-3, 1e12, 4e12),
    "us": (1e-6, 1e15, 4e15),
    "ns": (1e-9, 1e18, 4e18),
}
"""Seconds of a unit, and counts of it since 1970 that mean the years from 2001 to 2096."""


def times(sheet: Sheet, place: Place, date: Place | None = None) -> tuple[Array, str]:
    """Seconds from the first row, and what the column was taken for.

    A place's unit may be the form of its dates, as `%d/%m/%Y %H:%M:%S`; `date` is the column of dates where
    the other has the time of the day alone. InputError is raised where a time is missing or cannot be read,
    times do not increase, or day and month could be swapped.
    """
    column, cells = place.column, sheet.cells[place.column]
    if cells.empty:
        raise InputError(f"{sheet.name}: there are no rows under the header; give what was measured")
    kind = cells.dtype.kind
    written = cells.dropna().head(200).astype(str).str.strip()
    if kind not in "mMiufb" and (unit := _unit_in(written.tolist())):
        sheet, place = _without_unit(sheet, place, unit)
        written = written.str.removesuffix(unit).str.strip()
    counts = sum(bool(NUMBER.fullmatch(cell)) for cell in written)
    if kind in "mM":
        values, taken = seconds(cells), "date" if kind == "M" else "duration"
    elif not _is_form(place.unit) and (kind in "iufb" or 2 * counts > len(written) or written.empty):
        values, taken = _counted(sheet, column, place.unit)
    else:
        text = as_written(cells, place.unit or "") if kind in "iuf" else cells.astype(str)
        text = text.where(cells.notna(), "").str.strip()
        if date is not None:
            text = sheet.cells[date.column].astype(str).str.strip().str.removesuffix(" 00:00:00") + " " + text
        values, taken = _written(sheet, column, text, place.unit)
    return _checked(sheet, column, values), taken


def _is_form(unit: str | None) -> bool:
    """Whether a unit is a form of dates, as `%d/%m/%Y %H:%M:%S`."""
    return unit is not None and "%" in unit


def _unit_in(cells: Sequence[str]) -> str:
    """Unit of time that stands behind the number in all of some cells, empty if none does."""
    counts = [COUNT.fullmatch(cell) for cell in cells]
    units = {count[1] if count else "" for count in counts}
    return units.pop() if len(units) == 1 else ""


def _without_unit(sheet: Sheet, place: Place, unit: str) -> tuple[Sheet, Place]:
    """Times without the unit in their cells, which their place has instead; InputError where both differ."""
    where, column = sheet.of(place.column), place.column
    if place.unit is not None and not _is_form(place.unit):
        one, other = (conversion_to(each, "s", where, difference=True)[0] for each in (place.unit, unit))
        if one.factor != other.factor:
            raise InputError(f"{where}: its header says {place.unit}, its cells {unit}; correct the header")
    cells = sheet.cells.copy()
    cells[column] = (
        cells[column].astype(str).where(cells[column].notna(), "").str.strip().str.removesuffix(unit)
    )
    return replace(sheet, cells=cells), replace(place, unit=unit)


def _counted(sheet: Sheet, column: int, unit: str | None) -> tuple[Array, str]:
    values, lost = numbers(sheet, column, ordinary=None)
    sheet.refuse(lost, column, "{} is no time; correct it or remove the row")
    if unit is not None:
        conversion, unit = conversion_to(unit, "s", sheet.of(column), difference=True)
        return conversion.factor * values, unit
    middle = float(np.nanmedian(values)) if np.isfinite(values).any() else 0.0
    for unit, (factor, low, high) in _EPOCHS.items():
        if low <= middle <= high:
            return values * factor, f"{unit} since 1970"
    name = sheet.headers[column]
    raise InputError(
        f"{sheet.of(column)} has no unit; head it as '{name} [s]', or give {argument('units', {name: 's'})}"
    )


def _written(sheet: Sheet, column: int, text: pd.Series, form: str | None) -> tuple[Array, str]:
    """Seconds of written dates or times of the day; InputError at the first cell that is none."""
    try:
        return written_seconds(text, form, sheet.headers[column])
    except NoTimeError as wrong:
        cell = shown(str(text.iloc[wrong.row]))  # with its date, which may be in another column
        told = wrong.sentence.replace("{}", cell)
        raise InputError(f"{sheet.at(wrong.row, column)}: {told}") from None


def _checked(sheet: Sheet, column: int, values: Array) -> Array:
    """Times from 0; raises InputError where one is missing or comes too early."""
    sheet.refuse(
        np.flatnonzero(~np.isfinite(values)), column, "the time is missing; give it or remove the row"
    )
    for row in np.flatnonzero(np.diff(values, prepend=-np.inf) <= 0)[:1].tolist():
        raise InputError(f"{sheet.at(row, column)}: {_out_of_order(sheet, column, row, values)}")
    return values - values[0]


def of_skipped_hour(sheet: Sheet, column: int, values: Array) -> list[str]:
    """Remark where times in s, as `times` gives them, may count an hour that clocks skipped."""
    cells, steps = sheet.cells[column], np.diff(values)
    if cells.dtype.kind in "miuf":
        return []
    for row in (1 + np.flatnonzero((steps >= HOUR) & (steps <= HOUR + _BESIDE))).tolist():
        ends = [_WALL.fullmatch(str(cells.iloc[each]).strip()) for each in (row - 1, row)]
        before, after = (end and int(end["hour"]) for end in ends)
        days = [datetime.fromisoformat(end["day"]).weekday() for end in ends if end and end["day"]]
        if before in (0, 1) and after == before + 2 and all(day == _SUNDAY for day in days):
            earlier, later = (sheet.cell(each, column) for each in (row - 1, row))
            told = (
                f"{later} is taken to come {steps[row - 1]:g} s after {earlier}; if clocks were put forward"
            )
            remedy = "take an hour off the times from this row on, or write all in UTC or with their offset"
            return [f"{sheet.at(row, column)}: {told} between, as for summer time, {remedy}"]
    return []


def _out_of_order(sheet: Sheet, column: int, row: int, values: Array) -> str:
    """What is wrong with a row that comes no later than the one before, and the remedy."""
    step = values[row] - values[row - 1]
    if sheet.cells[column].dtype.kind not in "iuf" and -HOUR < step <= _BESIDE - HOUR:
        return (
            f"{sheet.cell(row, column)} comes after {sheet.cell(row - 1, column)}: the clock goes back by an "
            "hour, as at the end of summer time; add an hour to the times from this row on, or write all in "
            "UTC or with their offset, as 2025-10-26T02:00:00+01:00"
        )
    return (
        f"{values[row]:.10g} s comes after {values[row - 1]:.10g} s; times must increase, so sort the rows, "
        "and give fractions of a second where rows come faster"
    )

"""Times in seconds from the first row: numbers, dates as loggers write them, a clock over midnight."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.scenarios.logged.cells import numbers
from warmlink.orchestration.scenarios.logged.layout import COUNT, NUMBER, conversion_to
from warmlink.orchestration.scenarios.logged.sheet import Place, Sheet

if TYPE_CHECKING:
    import pandas as pd

HOUR, DAY = 3600.0, 86400.0
_BESIDE = 600.0
"""s by which two rows may be apart, between which an hour begins anew at the end of summer time."""

_EPOCHS = {"s": (1.0, 1e9, 4e9), "ms": (1e-3, 1e12, 4e12), "us": (1e-6, 1e15, 4e15)}
"""Seconds of a unit, and counts of it since 1970 that mean the years from 2001 to 2096."""

_MINUTES = re.compile(r"\d+:\d\d\.\d+")
_CLOCK = re.compile(r"\d+:\d\d(:\d\d(\.\d+)?)?")
_STAMP = re.compile(
    r"(?P<date>[\w./-]*?\d[\w./-]*|\d+ \w+ \d+|\w+ \d+,? \d+)(?P<between>T|,? +)(?P<clock>\d+:.*)"
)
_DATES = (
    (r"\d{4}([-/.])\d+\1\d+", ("%Y-%m-%d",)),
    (r"\d+\.\d+\.\d{4}", ("%d.%m.%Y",)),
    (r"\d+\.\d+\.\d{2}", ("%d.%m.%y",)),
    (r"\d+([-/])\d+\1\d{4}", ("%d-%m-%Y", "%m-%d-%Y")),
    (r"\d+([-/])\d+\1\d{2}", ("%d-%m-%y", "%m-%d-%y", "%y-%m-%d")),
    (r"\d+([- ])[A-Za-z]{3}\1\d{4}", ("%d-%b-%Y",)),
)
"""Dates by their look, each with the orders of day, month and year that it may have."""


def times(sheet: Sheet, place: Place, date: Place | None = None) -> tuple[Array, str]:
    """Seconds from the first row, and what the column was taken for.

    A place's unit may be the form of its dates, as `%d/%m/%Y %H:%M:%S`; `date` is the column of dates where
    the other has the time of the day alone. InputError is raised where a time is missing or cannot be read,
    times do not increase, or a date may mean two days.
    """
    column, cells = place.column, sheet.cells[place.column]
    if cells.empty:
        raise InputError(f"{sheet.name}: there are no rows under the header; give what was measured")
    kind = cells.dtype.kind
    written = cells.dropna().astype(str).str.strip().head(200)
    if kind not in "mMiufb" and (unit := _unit_in(written.tolist())):
        sheet, place = _without_unit(sheet, place, unit)
        written = written.str.removesuffix(unit).str.strip()
    counts = sum(bool(NUMBER.fullmatch(cell)) for cell in written)
    if kind in "mM":
        values, taken = _seconds(cells), "date" if kind == "M" else "duration"
    elif kind in "iufb" or 2 * counts > len(written) or written.empty:
        values, taken = _counted(sheet, column, place.unit)
    else:
        text = cells.astype(str).where(cells.notna(), "").str.strip()
        if date is not None:
            text = sheet.cells[date.column].astype(str).str.strip().str.removesuffix(" 00:00:00") + " " + text
        values, taken = _stamped(sheet, column, text, place.unit)
    return _checked(sheet, column, values), taken


def _unit_in(cells: Sequence[str]) -> str:
    """Unit of time that stands behind the number in all of some cells, empty if none does."""
    counts = [COUNT.fullmatch(cell) for cell in cells]
    units = {count[1] if count else "" for count in counts}
    return units.pop() if len(units) == 1 else ""


def _without_unit(sheet: Sheet, place: Place, unit: str) -> tuple[Sheet, Place]:
    """Times without the unit in their cells, which their place has instead; InputError where both differ."""
    where, column = sheet.of(place.column), place.column
    if place.unit is not None and "%" not in place.unit:
        one, other = (conversion_to(each, "s", where, difference=True)[0] for each in (place.unit, unit))
        if one.factor != other.factor:
            raise InputError(f"{where}: its header says {place.unit}, its cells {unit}; correct the header")
    cells = sheet.cells.copy()
    cells[column] = (
        cells[column].astype(str).where(cells[column].notna(), "").str.strip().str.removesuffix(unit)
    )
    return replace(sheet, cells=cells), replace(place, unit=unit)


def _seconds(cells: Any) -> Array:
    """Seconds from the first filled cell of dates or durations, NaN where there is none."""
    found = (cells - cells.dropna().iloc[0]) if cells.notna().any() else cells
    return np.asarray(found.dt.total_seconds(), dtype=np.float64)


def _counted(sheet: Sheet, column: int, unit: str | None) -> tuple[Array, str]:
    values, lost = numbers(sheet, column)
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


def _stamped(sheet: Sheet, column: int, text: pd.Series, form: str | None) -> tuple[Array, str]:
    """Seconds of written dates or times of the day."""
    sheet.refuse(np.flatnonzero(text == ""), column, "the time is missing")
    if form is not None and "%" in form:
        return _by_forms(sheet, column, text, [form])
    text = text.str.replace(r"(:\d\d),(\d+)", r"\1.\2", regex=True)
    first = str(text.iloc[0])
    if text.str.fullmatch(_MINUTES).any():
        return _of_minutes(sheet, column, text)
    if _CLOCK.fullmatch(first):
        return _of_clock(sheet, column, text)
    stamp = _STAMP.fullmatch(first)
    look = stamp["date"] if stamp else first
    orders = next((orders for pattern, orders in _DATES if re.fullmatch(pattern, look)), None)
    if orders is None or stamp is None:
        say = argument("units", {sheet.headers[column]: "%d/%m/%Y %H:%M:%S"})
        raise InputError(
            f"{sheet.at(0, column)}: {first!r} is no date with a time that can be read; write it as "
            f"2026-11-22 08:59:31, or give its form, as {say}"
        )
    clock = stamp["clock"]
    if orders[0] == "%Y-%m-%d" and not re.search(r"[AaPp]\.?[Mm]", clock):
        text = text.str.replace(r"^(\d{4})[/.](\d+)[/.](\d+)", r"\1-\2-\3", regex=True)
        return _by_forms(sheet, column, text, ["ISO8601"])
    if "." not in look:
        text = text.str.replace(r"^(\w+)[-/ ](\w+)[-/ ]", r"\1-\2-", regex=True)
    seconds = ":%S" if clock.count(":") > 1 else ""
    hours = f"%I:%M{seconds} %p" if clock[-1] in "Mm" else f"%H:%M{seconds}"
    return _by_forms(sheet, column, text, [f"{order}{stamp['between']}{hours}" for order in orders])


def _by_forms(sheet: Sheet, column: int, text: pd.Series, forms: list[str]) -> tuple[Array, str]:
    """Seconds by the one form that all rows have, or by forms that all give the same seconds."""
    import pandas as pd

    found: dict[str, Array] = {}
    worst = 0
    for form in forms:
        stamps = pd.to_datetime(text, format=form, errors="coerce", utc=form == "ISO8601")
        if "%f" not in form and "%S" in form:
            stamps = stamps.fillna(pd.to_datetime(text, format=form.replace("%S", "%S.%f"), errors="coerce"))
        if not stamps.hasnans:
            found[form] = _seconds(stamps)
        worst = max(worst, int(np.argmax(stamps.isna())))
    if not found:
        sheet.refuse(np.array([worst]), column, "{} is not of the form of the rows before; correct it")
    (form, values), *others = found.items()
    if any(not np.array_equal(values, other) for _, other in others):
        name = sheet.headers[column]
        raise InputError(
            f"{sheet.at(0, column)}: {text.iloc[0]!r} may begin with the day or the month, which gives other "
            f"times; say which, as {argument('units', {name: form.replace('-', '/')})}, or write dates as "
            "2026-11-22"
        )
    return values, f"date {form.replace('%', '')}" if form != "ISO8601" else "date"


def _of_clock(sheet: Sheet, column: int, text: pd.Series) -> tuple[Array, str]:
    """Seconds of HH:MM:SS, going on after midnight."""
    import pandas as pd

    example = argument("units", {sheet.headers[column]: "%H:%M"})
    told = f"write it so, or give its form, as {example} or %M:%S"
    wrong = np.flatnonzero(~text.str.fullmatch(r"\d+:\d\d:\d\d(\.\d+)?"))
    sheet.refuse(wrong, column, f"{{}} is not of the form HH:MM:SS; {told}")
    values = pd.to_timedelta(text).dt.total_seconds().to_numpy(dtype=float)
    midnights = np.diff(values, prepend=values[0]) < -DAY / 2
    return values + DAY * np.cumsum(midnights), "HH:MM:SS"


def _of_minutes(sheet: Sheet, column: int, text: pd.Series) -> tuple[Array, str]:
    """Seconds of M:SS.S, which may go on with H:MM:SS.S, or with 0:00.0 after an hour."""
    wrong = np.flatnonzero(~text.str.fullmatch(r"(\d+:)?\d+:\d\d(\.\d+)?"))
    sheet.refuse(wrong, column, "{} is not of the form M:SS.S of other rows; correct it")
    values = np.array([_seconds_of(cell) for cell in text])
    within_hours = bool((values < HOUR).all())
    hours = (np.diff(values, prepend=values[0]) < -HOUR / 2) & within_hours
    return values + HOUR * np.cumsum(hours), "M:SS.S"


def _seconds_of(cell: str) -> float:
    """Seconds of numbers between colons, the last of which are seconds."""
    seconds = 0.0
    for part in cell.split(":"):
        seconds = 60 * seconds + float(part)
    return seconds


def _checked(sheet: Sheet, column: int, values: Array) -> Array:
    """Times from 0; raises InputError where one is missing or comes too early."""
    sheet.refuse(
        np.flatnonzero(~np.isfinite(values)), column, "the time is missing; give it or remove the row"
    )
    for row in np.flatnonzero(np.diff(values, prepend=-np.inf) <= 0)[:1].tolist():
        raise InputError(f"{sheet.at(row, column)}: {_out_of_order(sheet, column, row, values)}")
    return values - values[0]


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

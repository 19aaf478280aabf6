"""Columns of cells as signals in SI: numbers, and what stands for no reading."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Scalar, limits
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.scenarios.logged.layout import NUMBER, conversion_to
from warmlink.orchestration.scenarios.logged.sheet import DECIMALS, Place, Sheet
from warmlink.orchestration.text_files import shown

Rows = NDArray[np.intp]

MOST_PLAUSIBLE = {"K": (150.0, 1500.0), "m": (-0.01, 0.01)}
"""Range of a credible temperature or growth by SI unit; beyond it the sensor errs, or the unit is wrong."""

_PADS = ("pad_temperature", "pad_power")
"""Ends of the inputs whose empty cells switch a pad off."""

_OFF = ("off", "none")
"""Words that stand for an empty cell of a pad, in small letters."""

OVERRANGE = 1e30
"""From here on a number stands for "no reading": 9.9E37, 1e99 and infinity are written for an overload."""

MARKS = (999.0, 999.9, 999.99, 9999.0, 9999.9, 99999.0, 999999.0, 32767.0, 32768.0, 65535.0)
_FAR = 3.0
"""Numbers that stand for "no reading" where they are so many times larger than all others in the column."""

_ORDINARY = {"rad/s": 300.0, "N.m": 1000.0, "W": 1000.0}
"""Sizes by SI unit up to which such a number is a reading all the same where all others are 0."""


@dataclass(frozen=True)
class Column:
    """A column that was read: its name and unit as people read them, and the variable that it is.

    Its `header` as written, where its unit stands, how many cells have a reading of how many, and the least
    and largest reading, in its unit.
    """

    name: str
    unit: str
    variable: str
    header: str = ""
    unit_from: str = "header"
    filled: int = 0
    cells: int = 0
    least: float | None = None
    largest: float | None = None


def signal(sheet: Sheet, place: Place, scalar: Scalar | None) -> tuple[Column, Array, Rows]:
    """A column's values in SI, NaN where there is no reading, and the rows whose cells hold something else.

    Without a `scalar`, the variable that it is, it is a covariate: a temperature. InputError is raised
    where nothing says its unit, that is of another quantity, or a cell cannot be understood.
    """
    si_unit = "K" if scalar is None else scalar.variable.unit
    temperature = scalar is None or scalar.is_temperature
    header = sheet.headers[place.column]
    if place.unit is None:
        shorter = place.name if " " not in place.name else header
        usual = "degC" if temperature else {"m": "um"}.get(si_unit, si_unit)
        raise InputError(
            f"{sheet.of(place.column)} has no unit; head it as '{shorter} [{usual}]', or give "
            f"{argument('units', {shorter: usual})}"
        )
    conversion, unit = conversion_to(place.unit, si_unit, sheet.of(place.column), difference=not temperature)
    off = _OFF if place.variable.endswith(_PADS) else ()
    read, lost = numbers(sheet, place.column, off, _ORDINARY.get(si_unit, 0.0) / abs(conversion.factor))
    values = conversion.factor * read + conversion.offset
    if scalar is None or temperature or scalar.variable.display == "um":
        low, high = MOST_PLAUSIBLE[si_unit]
        beyond = np.flatnonzero((values < low) | (values > high))
        if 2 * beyond.size > values.size:
            raise InputError(
                f"{sheet.of(place.column)}: half of the values lie about {np.nanmedian(values):.4g} "
                f"{si_unit}, outside {low:g} to {high:g} {si_unit}; the unit in the header seems wrong"
            )
        lost = np.union1d(lost, beyond)
        values[beyond] = np.nan
    seen = read[np.isfinite(values)]
    ends = (float(seen.min()), float(seen.max())) if seen.size else (None, None)
    column = Column(place.name, unit, place.variable, header, place.source, seen.size, read.size, *ends)
    return column, values, lost


def without_gaps(sheet: Sheet, place: Place, values: Array, lost: Rows) -> Array:
    """Values with the last one in each empty cell; in those of a pad it is off: no temperature, or no power.

    InputError is raised where there is no value at all, or none in the first row.
    """
    filled = np.isfinite(values)
    if place.variable.endswith(_PADS):
        values = np.where(~filled & place.variable.endswith("power"), 0.0, values)
        filled[:] = True
        filled[lost] = False
    elif not filled.any():
        raise InputError(f"{sheet.of(place.column)} is empty; give the input or leave the column out")
    sheet.refuse(np.flatnonzero(~filled[:1]), place.column, "an input needs a value in the first row")
    return values[np.maximum.accumulate(np.where(filled, np.arange(filled.size), 0))]


def as_input(sheet: Sheet, place: Place, scalar: Scalar | None) -> tuple[Column, Array, list[str]]:
    """A column of an input, its values in SI in every row, and remarks on cells that are missing or empty.

    InputError as `signal` and `without_gaps`, or a cell is no value of a discrete input, as 1.5 for a pad.
    """
    column, values, lost = signal(sheet, place, scalar)
    if scalar is not None and scalar.is_discrete:
        for row in np.flatnonzero(np.isfinite(values)).tolist():
            sentence = limits.problem(scalar, float(values[row]))
            if sentence is not None:
                raise InputError(f"{sheet.at(row, place.column)}: {sentence}")
    missing = [sheet.taken_for_missing(lost, place.column)] if lost.size else []
    return column, without_gaps(sheet, place, values, lost), [*missing, *said_of_empty(sheet, place)]


def said_of_empty(sheet: Sheet, place: Place) -> list[str]:
    """Say what an input's empty cells are taken for; nothing for a pad's temperature, which is off there."""
    cells: Any = sheet.cells[place.column]
    blank = cells.isna()
    if cells.dtype.kind not in "iufb":  # else nothing is blank that is not absent
        blank |= cells.astype(str).str.strip() == ""
    empty = int(np.count_nonzero(blank))
    if not empty or place.variable.endswith("pad_temperature"):
        return []
    taken = "the value before; where it was off, write 0"
    if place.variable.endswith("temperature"):
        taken = "the value before"
    elif place.variable.endswith(_PADS):
        taken = "off"
    return [f"{sheet.name}: {empty} of {cells.size} cells of {place.name} are empty and taken for {taken}"]


def numbers(
    sheet: Sheet, column: int, empty: Sequence[str] = (), ordinary: float | None = 0.0
) -> tuple[Array, Rows]:
    """Numbers of a column in its own unit, NaN where a cell is empty or holds none, shape (rows,).

    Beside them the rows of cells that hold words or numbers that stand for "no reading"; those in `empty`, in
    small letters, stand for an empty cell. Up to an `ordinary` size a number is a reading where all others
    are 0, and of any size where that is None, as for times. InputError is raised where a cell may be read in
    two ways, looks like a number and is none, or most cells are words.
    """
    cells: Any = sheet.cells[column]
    if cells.dtype.kind in "iufb":
        values, words = cells.to_numpy(dtype=float, na_value=np.nan), np.flatnonzero([])
    else:
        values, words = _of_text(sheet, column, empty)
    size = np.abs(values)
    marks = np.isin(size, MARKS)
    usual = float(np.nanmax(np.where(marks | (size >= OVERRANGE), 0.0, size), initial=0.0))
    most = np.inf if ordinary is None else _FAR * usual or ordinary
    none = (size >= OVERRANGE) | (marks & (size > most))
    return np.where(none, np.nan, values), np.union1d(words, np.flatnonzero(none))


def _of_text(sheet: Sheet, column: int, empty: Sequence[str]) -> tuple[Array, Rows]:
    """Numbers of cells that are text, NaN where there is none, and the rows of words."""
    import pandas as pd

    cells: Any = sheet.cells[column]
    # A cell that is a number has no decimal mark that somebody wrote.
    own = cells.map(lambda cell: isinstance(cell, float | np.floating | Decimal)) & cells.notna()
    text = cells.astype(str).str.strip().where(cells.notna() & ~own, "").astype(object)
    text = text.where(~text.str.lower().isin(empty), "")
    mark = DECIMALS.get(sheet.decimal, "")
    doubtful = text.str.contains("." if mark == "," else ",", regex=False).to_numpy(dtype=bool)
    plain = text.str.replace(",", ".", regex=False) if mark == "," else text.copy()
    for row in np.flatnonzero(doubtful).tolist():
        plain.iloc[row] = _without_thousands(sheet, row, column, text.iloc[row], mark)
    parsed = pd.to_numeric(plain, errors="coerce")
    words = np.flatnonzero((parsed.isna() & (text != "")).to_numpy())
    wrong = text.iloc[words].str.fullmatch(r"(?=[\W\d_])[^#]*\d[^#]*").to_numpy(dtype=bool)
    sheet.refuse(words[wrong], column, "{} is not a number; correct it or leave the cell empty")
    if 2 * words.size > np.count_nonzero((text != "") | own):
        raise InputError(
            f"{sheet.at(int(words[0]), column)}: {shown(text.iloc[words[0]])} and most cells below are no "
            "numbers; correct them, or leave the column out with "
            f"{argument('names', {sheet.headers[column]: ''})}"
        )
    return plain.where(parsed.notna(), np.nan).where(~own, cells).astype(float).to_numpy(), words


def _without_thousands(sheet: Sheet, row: int, column: int, cell: str, mark: str) -> str:
    """A number that has another mark than the file's decimal one, as Python writes it; a word as it is."""
    if not NUMBER.fullmatch(cell):
        return cell
    other = "." if mark == "," else ","
    grouped = rf"[-+]?[1-9]\d{{0,2}}(?:{re.escape(other)}\d{{3}})+(?:{re.escape(mark)}\d*)?"
    if mark and re.fullmatch(grouped, cell) and (mark in cell or sheet.said):
        return cell.replace(other, "").replace(mark, ".")
    raise InputError(
        f"{sheet.at(row, column)}: {shown(cell)} may have a decimal mark or one for thousands; write all "
        f"numbers alike, or say {argument('decimal', 'comma')} or {argument('decimal', 'point')}"
    )

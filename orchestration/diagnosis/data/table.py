"""Columns of measurements in SI: readings that can be, inputs that hold until the next row."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component import Scalar, limits
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.columns import Place
from warmlink.orchestration.diagnosis.data.headings import conversion_to
from warmlink.orchestration.diagnosis.data.numbers import between_jumps, cell_shown, numbers, repeats
from warmlink.orchestration.diagnosis.data.sheet import Sheet

MOST_PLAUSIBLE = {"K": (150.0, 1500.0), "m": (-0.01, 0.01)}
"""Range of a credible temperature or growth by SI unit; beyond it the sensor errs, or the unit is wrong."""

_OFF = ("off", "none")
"""What a pad's cell says of a pad that is off, beside nothing at all."""


@dataclass(frozen=True)
class Column:
    """A column of the file that is used.

    Attributes
    ----------
    name, unit : of the header, as people read them
    variable : that it is
    header, source : as written, and where its unit stands
    filled, rows : cells with a reading, and all
    low, high : least and largest reading, in its unit
    """

    name: str
    unit: str
    variable: str
    header: str = ""
    source: str = "header"
    filled: int = 0
    rows: int = 0
    low: float = np.nan
    high: float = np.nan


@dataclass(frozen=True)
class Signal:
    """Values of a column in SI, shape (rows,), NaN where there is none; rows lost; a remark on these."""

    column: Column
    values: Array
    lost: NDArray[np.intp]
    remarks: tuple[str, ...]


def signal(sheet: Sheet, place: Place, si_unit: str, temperature: bool, growth: bool = False) -> Signal:
    """Values of a column in SI.

    Raises
    ------
    InputError
        Nothing says its unit, that is of another quantity, or a cell cannot be understood.
    """
    if place.unit is None:
        shorter = place.name if " " not in place.name else sheet.headers[place.column]
        raise InputError(
            f"{sheet.of(place.column)} has no unit; head it as '{shorter} [{_usual(si_unit, temperature)}]', "
            f'or give --unit "{shorter}={_usual(si_unit, temperature)}"'
        )
    conversion, unit = conversion_to(place.unit, si_unit, sheet.of(place.column), difference=not temperature)
    read, lost = numbers(sheet, place.column)
    values = conversion.factor * read + conversion.offset
    if temperature or growth:
        beyond = _implausible(sheet, place.column, values, si_unit)
        lost = np.union1d(lost, beyond)
        values[beyond] = np.nan
    own = np.where(np.isfinite(values), read, np.nan)
    seen = own[np.isfinite(own)]
    column = Column(
        place.name,
        unit,
        place.variable,
        sheet.headers[place.column],
        place.source,
        seen.size,
        own.size,
        float(seen.min()) if seen.size else np.nan,
        float(seen.max()) if seen.size else np.nan,
    )
    return Signal(column, values, lost, _remarks(sheet, place.column, lost))


def without_repeats(sheet: Sheet, found: Signal) -> Signal:
    """The same readings without those that only repeat the one before, and a remark on these."""
    again, held = repeats(found.values), between_jumps(found.values)
    if not again.size + held.size:
        return found
    why = (
        "repeat the one before and are left out; the sensor sticks, or the logger writes more often than it "
        "samples"
        if again.size
        else "lie between jumps and are left out; the sensor sticks, and is right when it has just jumped"
    )
    left_out = again if again.size else held
    told = f"{sheet.name}: {left_out.size} of {found.values.size} values of {found.column.name} {why}"
    values = found.values.copy()
    values[left_out] = np.nan
    return replace(found, values=values, remarks=(*found.remarks, told))


def _usual(si_unit: str, temperature: bool) -> str:
    return "degC" if temperature else {"m": "um"}.get(si_unit, si_unit)


def _remarks(sheet: Sheet, column: int, lost: NDArray[np.intp]) -> tuple[str, ...]:
    if not lost.size:
        return ()
    row = int(lost[0])
    more = f", as are {lost.size - 1} more in this column" if lost.size > 1 else ""
    return (f"{sheet.at(row, column)}: {cell_shown(sheet, row, column)} is taken for a missing value{more}",)


def _implausible(sheet: Sheet, column: int, values: Array, unit: str) -> NDArray[np.intp]:
    """Rows of readings that cannot be; raises InputError where they are half of all."""
    low, high = MOST_PLAUSIBLE[unit]
    beyond = (values < low) | (values > high)
    if 2 * np.count_nonzero(beyond) > values.size:
        middle = float(np.nanmedian(values))
        raise InputError(
            f"{sheet.of(column)}: half of the values lie about {middle:.4g} {unit}, outside "
            f"{low:g} to {high:g} {unit}; the unit in the header seems wrong"
        )
    return np.flatnonzero(beyond)


def held(sheet: Sheet, place: Place, found: Signal, empty_is_off: bool) -> Array:
    """Values with the last one in each empty cell; those of a pad stay empty, which is off.

    Raises
    ------
    InputError
        There is no value at all, or none in the first row.
    """
    filled = np.isfinite(found.values)
    if empty_is_off:
        filled = ~np.isin(np.arange(filled.size), found.lost) | _off(sheet, place, found.lost)
    elif not filled.any():
        raise InputError(f"{sheet.of(place.column)} is empty; give the input or leave the column out")
    if not filled[0]:
        raise InputError(f"{sheet.at(0, place.column)}: an input needs a value in the first row")
    last = np.maximum.accumulate(np.where(filled, np.arange(filled.size), 0))
    return found.values[last]


def _off(sheet: Sheet, place: Place, rows: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Rows in which a pad's cell says that it is off."""
    off = np.zeros(len(sheet.cells), dtype=bool)
    for row in rows:
        off[row] = str(sheet.cells[place.column].iloc[row]).strip().lower() in _OFF
    return off


def refuse_undefined(sheet: Sheet, place: Place, values: Array, scalar: Scalar) -> None:
    """Raise InputError where a cell is not a value of a discrete input, as 1.5 for the pad's mode."""
    for row in np.flatnonzero(np.isfinite(values)).tolist():
        sentence = limits.problem(scalar, float(values[row]))
        if sentence is not None:
            raise InputError(f"{sheet.at(row, place.column)}: {sentence}")

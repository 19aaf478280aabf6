"""Recorded duty cycles: CSV files as loggers write them, also those of a run that `diagnose` reads."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from warmlink.controllers.interface import SENSED
from warmlink.fmus.duty_cycle.component import COMPONENT
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.scenarios.duties.duty import UNITS, Duty, Segment, padded
from warmlink.orchestration.scenarios.logged.cells import held, signal
from warmlink.orchestration.scenarios.logged.clock import times
from warmlink.orchestration.scenarios.logged.layout import TIME, TIMES, name_and_unit, plain, with_suffix
from warmlink.orchestration.scenarios.logged.sheet import Place, Sheet, read_sheet
from warmlink.orchestration.text_files import demand_file, shown

RECORDED = {TIME: "s", **{name: unit for name, unit in UNITS.items() if name != "duration"}}
"""SI unit of each column that makes the duty cycle."""

MEASURED = (*SENSED, "elongation")
"""Columns that may stand beside it, as in a run that `diagnose` reads; they are no part of the duty cycle."""

_DEMANDS = {scalar.name: scalar for scalar in COMPONENT.scalars()}


def read_csv(path: Path) -> Duty:
    """Recorded duty cycle from a CSV file with columns named `name [unit]`, `time [s]` among them.

    Inputs hold until the next row, an empty cell holds the last value, an empty pad cell switches the pad
    off. Rows in sequence that demand the same make one segment.

    Raises InputError where the file cannot be read, a column or unit is not known or stands twice, a cell
    holds no reading, or time does not increase.
    """
    demand_file(path, "give an existing .toml or .csv")
    sheet = read_sheet(path)
    places = _places(sheet)
    at, _ = times(sheet, places.pop(TIME))
    if at.size < 2:
        raise InputError(f"{path.name}: {at.size} rows under the header; give at least two times")
    rows = _rows(sheet, {name: _demand(sheet, place) for name, place in places.items()})[:-1]
    begins = [i for i, row in enumerate(rows) if i == 0 or row != rows[i - 1]]
    lasting = np.diff([*at[begins], at[-1]]).tolist()
    segments = tuple(replace(rows[i], duration=lasts) for i, lasts in zip(begins, lasting, strict=True))
    absent = [name for name in ("speed", "torque") if name not in places]
    told = (f"{path.name} has no column {name}, which is taken as 0 {RECORDED[name]}" for name in absent)
    reason = f"recorded, {path.name}"
    return Duty(path.stem, path.stem, reason, float(at[-1]), segments, remarks=tuple(told))


def _places(sheet: Sheet) -> dict[str, Place]:
    """Column of time and of each demand, by name."""
    found: dict[str, Place] = {}
    for column, header in enumerate(sheet.headers):
        written, unit = name_and_unit(header)
        unit = unit or sheet.units[column]
        forms: list[tuple[str, str | None]] = [(written, unit), *(() if unit else with_suffix(written))]
        name, unit = next((form for form in forms if _known(form[0])), forms[0])
        variable = _known(name)
        if not variable:
            known = instead(plain(name), (*RECORDED, *MEASURED), "or remove it")
            raise InputError(f"{sheet.name}: column {shown(header)} is not known; {known}")
        if variable in found:
            one = sheet.headers[found[variable].column]
            raise InputError(f"{sheet.name}: columns {one!r} and {header!r} are both {variable}; keep one")
        if unit is None and variable in _DEMANDS:
            raise InputError(f"{sheet.of(column)} has no unit; write '{name} [{RECORDED[variable]}]'")
        found[variable] = Place(column, name, unit, variable, "header", chosen=False)
    if TIME not in found:
        raise InputError(f"{sheet.name}: no column 'time [s]'; add it")
    return {name: place for name, place in found.items() if name in RECORDED}


def _known(name: str) -> str:
    """Column that a name says; empty where it says none."""
    short = plain(name)
    return TIME if short in TIMES else short if short in (*RECORDED, *MEASURED) else ""


def _demand(sheet: Sheet, place: Place) -> Array:
    """Values of a demand in SI, row by row; NaN where a pad is off."""
    _, values, lost = signal(sheet, place, _DEMANDS[place.variable])
    sheet.refuse(lost, place.column, "{} is no reading; mend or empty it")
    if place.variable.startswith("pad_"):
        return values
    if not np.isfinite(values[0]):
        values[0] = getattr(Segment(0.0), place.variable)
    return held(sheet, place, values, lost)


def _rows(sheet: Sheet, demands: Mapping[str, Array]) -> list[Segment]:
    """Demands of each row; raises InputError where one gives a pad's temperature and its power."""
    columns = {name: values.tolist() for name, values in demands.items()}
    found = []
    for i, line in enumerate(sheet.cells.index):
        given = {name: values[i] for name, values in columns.items() if math.isfinite(values[i])}
        try:
            pad = padded(given.pop("pad_temperature", None), given.pop("pad_power", None))
        except InputError as fault:
            raise InputError(f"{sheet.name}: row {line}: {fault}") from None
        found.append(Segment(0.0, **given, **pad))
    return found

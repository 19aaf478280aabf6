"""Recorded duties: files as loggers write them, also those of a run that `diagnose` reads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np

from warmlink.controllers.interface import SENSED
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.component.table import Played
from warmlink.fmus.duty_cycle.component import COMPONENT
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.recorded_duty.component import COMPONENT as PLAYER
from warmlink.fmus.recorded_duty.component import duty_table
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.scenarios.duties.duty import (
    NO_PAD,
    PAD_POWER,
    PAD_TEMPERATURE,
    UNITS,
    Drive,
    Recorded,
    RecordedSegments,
    Segment,
    padded,
)
from warmlink.orchestration.scenarios.logged.cells import signal, without_gaps
from warmlink.orchestration.scenarios.logged.clock import of_skipped_hour, times
from warmlink.orchestration.scenarios.logged.layout import TIME, TIMES, Heading, converts, plain, with_suffix
from warmlink.orchestration.scenarios.logged.sheet import Place, Sheet, read_sheet
from warmlink.orchestration.text_files import demand_file, shown

RECORDED = {TIME: "s", **{name: unit for name, unit in UNITS.items() if name != "duration"}}
"""SI unit of each column that makes the duty cycle."""

MEASURED = (*SENSED, "elongation")
"""Columns that may stand beside it, as in a run that `diagnose` reads; they are no part of the duty cycle."""

_GROWTH = "growth"
"""Column of the true growth, where a log has one."""

_DEMANDS = {scalar.name: scalar for scalar in COMPONENT.scalars()}


def read_recorded(
    path: Path, linear: Sequence[str] = (), columns: Mapping[str, str] = MappingProxyType({})
) -> Drive:
    """Recorded duty from a table (CSV, Parquet) of columns named `name [unit]`, `time [s]` among them.

    Inputs hold until the next row, but those that are `linear` between rows; an empty cell holds the last
    value, an empty pad cell switches the pad off. Rows in sequence that demand the same make one segment: so
    few that DutyCycle holds them are segments, any number of others a table that is played.

    Where `columns` say what the file calls them, no others are read but the time.

    Raises InputError where the file cannot be read, a column or unit is not known or stands twice, a cell
    holds no reading, or time does not increase.
    """
    demand_file(path, "give an existing .toml, .csv or .parquet")
    sheet = read_sheet(path)
    places = _chosen(sheet, columns) if columns else _places(sheet)
    if TIME not in places:
        raise InputError(f"{sheet.name}: no column 'time [s]'; add it")
    time = places.pop(TIME)
    at, _ = times(sheet, time)
    if at.size < 2:
        raise InputError(f"{path.name}: {at.size} rows under the header; give at least two times")
    demands = _demanded(sheet, {name: _demand(sheet, place) for name, place in places.items()})
    absent = [name for name in ("speed", "torque") if name not in places]
    told = tuple(f"{path.name} has no column {name}, which is taken as 0 {RECORDED[name]}" for name in absent)
    told += tuple(of_skipped_hour(sheet, time.column, at))
    try:
        table = Played("rows", PLAYER.tables[0].columns, duty_table(at, demands, linear)).table
    except InputError as fault:
        raise InputError(f"{path.name}: {fault}") from None
    # Of the last row nobody knows how long it lasts.
    whole = Recorded(path.stem, path.stem, f"recorded, {path.name}", float(at[-1]), table, remarks=told)
    return RecordedSegments.of(whole)


def _places(sheet: Sheet) -> dict[str, Place]:
    """Column of time and of each demand, by name."""
    found: dict[str, Place] = {}
    for column, heading in enumerate(sheet.headings):
        header = heading.written
        name, unit = next((form for form in _forms(heading) if _known(form[0])), _forms(heading)[0])
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
    return {name: place for name, place in found.items() if name in RECORDED}


def _chosen(sheet: Sheet, columns: Mapping[str, str]) -> dict[str, Place]:
    """Column of time and of each demand, by name, as the user says it of the file's own names."""
    found: dict[str, Place] = {}
    for own, variable in columns.items():
        if variable not in RECORDED:
            told = f"{shown(variable)} is no column of a duty; {instead(variable, RECORDED)}"
            raise InputError(f"{sheet.name}: columns: {shown(own)}: {told}")
        fits = [i for i, each in enumerate(sheet.headings) if own in (each.name, each.written)]
        if len(fits) != 1:
            told = (
                "stands twice; rename one" if fits else instead(own, [each.name for each in sheet.headings])
            )
            raise InputError(f"{sheet.name}: columns: {'' if fits else 'no column '}{shown(own)}; {told}")
        if variable in found:
            raise InputError(f"{sheet.name}: columns: two columns are {variable}; keep one")
        heading = sheet.headings[fits[0]]
        measures = (form for form in _forms(heading) if form[1] and converts(form[1], RECORDED[variable]))
        name, unit = next(measures, (heading.name, heading.unit))
        found[variable] = Place(fits[0], name, unit, variable, heading.source, chosen=True)
    for i, heading in enumerate(sheet.headings):
        for name, unit in _forms(heading):
            if TIME not in found and _known(name) == TIME:
                found[TIME] = Place(i, name, unit, TIME, heading.source, chosen=False)
    return found


def _forms(heading: Heading) -> list[tuple[str, str | None]]:
    """Name and unit of a heading; without a unit every way in which the name may end in one, too."""
    return [(heading.name, heading.unit), *(() if heading.unit else with_suffix(heading.name))]


def _known(name: str) -> str:
    """Column that a name says; empty where it says none."""
    short = plain(name)
    return TIME if short in TIMES else short if short in (*RECORDED, *MEASURED, _GROWTH) else ""


def _demand(sheet: Sheet, place: Place) -> Array:
    """Values of a demand in SI, row by row; NaN where a pad is off."""
    _, values, lost = signal(sheet, place, _DEMANDS[place.variable])
    sheet.refuse(lost, place.column, "{} is no reading; mend or empty it")
    sheet.refuse(np.flatnonzero(values < 0), place.column, "{} is below 0; give absolute values")
    if place.variable.startswith("pad_"):
        return values
    if not np.isfinite(values[0]):
        values[0] = getattr(Segment(0.0), place.variable)
    return without_gaps(sheet, place, values, lost)


def _demanded(sheet: Sheet, demands: Mapping[str, Array]) -> dict[str, Array]:
    """Columns of the duty's table; raises InputError where a row gives a pad's temperature and its power."""
    found, rows = dict(demands), len(sheet.cells)
    off = np.full(rows, np.nan)
    temperature, power = (found.pop(name, off) for name in ("pad_temperature", "pad_power"))
    held, powered = np.isfinite(temperature), np.isfinite(power)
    for row in np.flatnonzero(held & powered)[:1].tolist():
        try:
            padded(temperature[row], power[row])
        except InputError as fault:
            raise InputError(f"{sheet.name}: row {sheet.cells.index[row]}: {fault}") from None
    found["pad_mode"] = np.select([held, powered], [PAD_TEMPERATURE, PAD_POWER], NO_PAD)
    found["pad_temperature"] = np.where(held, temperature, ROOM_TEMPERATURE)
    found["pad_power"] = np.where(powered, power, 0.0)
    return found

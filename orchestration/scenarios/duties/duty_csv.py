"""Recorded duty cycles in CSV files."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.controllers.interface import SENSED
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.scenarios.duties.duty import (
    NO_PAD,
    PAD_POWER,
    PAD_TEMPERATURE,
    UNITS,
    Duty,
    Segment,
)
from warmlink.orchestration.scenarios.quantity import converter, heading
from warmlink.orchestration.system.units import IDENTITY, Conversion
from warmlink.orchestration.text_files import read_text, shown

TIME, DURATION = "time", "duration"
DEMANDS = {TIME: "s", **{name: unit for name, unit in UNITS.items() if name != DURATION}}
"""SI unit of each column that makes the duty cycle."""

MEASURED = (*SENSED, "elongation")
"""Columns that may stand beside it, as in a run that `diagnose` reads; they are no part of the duty cycle."""


def read_csv(path: Path) -> Duty:
    """Recorded duty cycle from a CSV file with a header of `name [unit]`, `time [s]` first among them.

    Inputs hold until the next row, an empty cell holds the last value, an empty pad cell switches the pad
    off.

    Raises InputError where the file cannot be read, a column or unit is not known or stands twice, a row is
    longer or shorter than the header, a cell is no number, or time does not increase.
    """
    (_, header), *rows = _rows(path)
    columns = _columns(header, path.name)
    times: list[float] = []
    segments: list[Segment] = []
    last = Segment(0.0)
    for line, row in rows:
        where = f"{path.name}: line {line}"
        if len(row) != len(header):
            raise InputError(f"{where}: {len(row)} cells under {len(header)} columns; mend the row")
        cells = {name: _value(row[place], where, name, to_si) for name, (place, to_si) in columns.items()}
        time = cells.pop(TIME)
        if time is None or (times and time <= times[-1]):
            raise InputError(f"{where}: time is missing or does not increase; give increasing times")
        times.append(time)
        last = replace(last, **_held(cells, where))
        segments.append(last)
    if len(times) < 2:
        raise InputError(f"{path.name}: {len(times)} rows under the header; give at least two times")
    lasting = [replace(each, duration=float(d)) for each, d in zip(segments, np.diff(times), strict=False)]
    remarks = tuple(
        f"{path.name} has no column {name}, which is taken as 0 {DEMANDS[name]}"
        for name in ("speed", "torque")
        if name not in columns
    )
    reason, stop_time = f"recorded, {path.name}", times[-1] - times[0]
    return Duty(path.stem, path.stem, reason, stop_time, tuple(lasting), remarks=remarks)


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """Number and cells of each line that holds something, the header first."""
    reader = csv.reader(read_text(path, "give an existing .toml or .csv").splitlines())
    try:
        rows = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except csv.Error as fault:
        raise InputError(f"{path.name}: line {reader.line_num}: {fault}; mend the line") from None
    if not rows:
        raise InputError(f"{path.name}: is empty; give a header and at least two times")
    return rows


def _columns(header: list[str], where: str) -> dict[str, tuple[int, Conversion]]:
    """Place in the row and conversion to SI of each column of the duty cycle, by name."""
    found: dict[str, tuple[int, Conversion]] = {}
    for place, cell in enumerate(header):
        name, unit = heading(cell)
        if not name.isidentifier():
            raise InputError(f"{where}: column {shown(cell)} is not of the form 'name [unit]'; rename it")
        if name not in (*DEMANDS, *MEASURED):
            known = instead(name, (*DEMANDS, *MEASURED), "or remove it")
            raise InputError(f"{where}: column {shown(name)} is not known; {known}")
        if name in DEMANDS and not unit:
            raise InputError(f"{where}: column {name!r} has no unit; write '{name} [{DEMANDS[name]}]'")
        if name in found:
            raise InputError(f"{where}: column {name!r} stands twice; keep one")
        si = DEMANDS.get(name)
        found[name] = place, converter(unit or "", si, f"{where}: column {name!r}") if si else IDENTITY
    if TIME not in found:
        raise InputError(f"{where}: no column 'time [s]'; add it")
    return {name: column for name, column in found.items() if name in DEMANDS}


def _held(cells: Mapping[str, float | None], where: str) -> dict[str, Any]:
    """What a row changes: given cells, and the pad's mode by which of its cells is given."""
    changes: dict[str, Any] = {name: value for name, value in cells.items() if value is not None}
    if "pad_temperature" in changes and "pad_power" in changes:
        raise InputError(f"{where}: pad_temperature and pad_power exclude each other; give one")
    if "pad_temperature" in cells or "pad_power" in cells:
        by_power = PAD_POWER if "pad_power" in changes else NO_PAD
        changes["pad_mode"] = PAD_TEMPERATURE if "pad_temperature" in changes else by_power
    return changes


def _value(cell: str, where: str, name: str, to_si: Conversion) -> float | None:
    if not cell.strip():
        return None
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{where}: {shown(cell.strip())} in column {name!r} is no number; mend or empty it")
    return to_si(value)

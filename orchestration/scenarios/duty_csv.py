"""Recorded duty cycles in CSV files."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.orchestration.scenarios.duty import NO_PAD, PAD_TEMPERATURE, UNITS, Duty, Segment
from warmlink.orchestration.system.units import Conversion, conversion, parse_unit

_COLUMN = re.compile(r"^\s*(\w+)\s*(?:\[(.*)\])?\s*$")


def read_csv(path: Path) -> Duty:
    """Recorded duty cycle from a CSV file with a header of `name [unit]`, `time [s]` first among them.

    Inputs hold until the next row, an empty cell holds the last value, an empty pad cell switches the pad
    off.

    Raises
    ------
    InputError
        A column or unit is unknown, a cell is no number, or time does not increase.
    """
    with path.open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.reader(file) if any(cell.strip() for cell in row)]
    if len(rows) < 2:
        raise InputError(f"{path.name}: no rows; give a header and at least two times")
    columns = [_column(cell, path.name) for cell in rows[0]]
    labels = [name for name, _ in columns]
    if "time" not in labels:
        raise InputError(f"{path.name}: no column 'time [s]'; add it")
    times: list[float] = []
    segments: list[Segment] = []
    last = Segment(0.0)
    for number, row in enumerate(rows[1:], start=2):
        where = f"{path.name}: line {number}"
        cells = {
            name: convert(_number(cell, where, name)) if cell.strip() else None
            for (name, convert), cell in zip(columns, row, strict=False)
        }
        time = cells.pop("time", None)
        if time is None or (times and time <= times[-1]):
            raise InputError(f"{where}: time is missing or does not increase; give increasing times")
        times.append(time)
        last = replace(last, **_held(cells))
        segments.append(last)
    durations = np.diff(times)
    segments = [replace(s, duration=float(d)) for s, d in zip(segments, durations, strict=False)]
    if len(segments) < 1 or not len(durations):
        raise InputError(f"{path.name}: only one time; give at least two")
    return Duty(path.stem, path.stem, f"recorded, {path.name}", float(times[-1] - times[0]), tuple(segments))


def _held(cells: Mapping[str, float | None]) -> dict[str, Any]:
    """What a row changes: given cells, and the pad's mode by its temperature."""
    changes: dict[str, Any] = {
        name: value for name, value in cells.items() if value is not None and name in UNITS
    }
    if "pad_temperature" in cells:
        changes["pad_mode"] = NO_PAD if cells["pad_temperature"] is None else PAD_TEMPERATURE
    return changes


def _column(cell: str, where: str) -> tuple[str, Callable[[float], float]]:
    match = _COLUMN.match(cell)
    if match is None:
        raise InputError(f"{where}: column {cell!r} is not of the form 'name [unit]'; rename it")
    name, unit = match[1], match[2]
    target = "s" if name == "time" else UNITS.get(name)
    if target is None:  # measured channels may stand beside the duty; they are not part of it
        return name, Conversion()
    if not unit:
        raise InputError(f"{where}: column {name!r} has no unit; write '{name} [{target}]'")
    try:
        return name, conversion(parse_unit(unit), parse_unit(target))
    except InputError as fault:
        raise InputError(f"{where}: column {name!r}: {fault}; give it in {target}") from None


def _number(cell: str, where: str, name: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{where}: {cell.strip()!r} in column {name!r} is no number; mend or empty the cell")
    return value

"""Rows of a log that no machine made: readings that leap away and back at once, and rows of zeros."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.signals import quantum, row_noise
from warmlink.orchestration.scenarios.logged.cells import Column, Rows
from warmlink.orchestration.scenarios.logged.sheet import Sheet
from warmlink.orchestration.system.units import parse_unit

_LONGEST = 3
"""Rows for which a reading may be away and come back."""

_FAR, _LEAP = 20.0, 5.0
"""Standard deviations of the noise, and multiples of the largest usual step, that a leap is at least."""

_USUAL = 0.98
"""Share of all steps from row to row that are usual."""

_BACK = 0.25
"""Share of a leap by which the reading may differ afterwards from what it was before."""

_MOST_NAMED = 8


def leaping(values: Array) -> Rows:
    """Rows in which a reading is far from those before and after, which go on as if nothing had been.

    Heat makes no such course: what leaps within a row would have to leap back within three. Unlike spikes
    that thinning removes, these are no matter of judgement.
    """
    rows = np.flatnonzero(np.isfinite(values))
    read = values[rows]
    if read.size < 4 * _LONGEST:
        return rows[:0]
    steps = np.diff(read)
    step = max(quantum(values), 1e-9 * float(np.abs(read).max()))
    limit = max(_FAR * max(row_noise(values), step / 2), _LEAP * float(np.quantile(np.abs(steps), _USUAL)))
    found = np.zeros(read.size, dtype=bool)
    away = np.flatnonzero(np.abs(steps) > limit)
    for first in away.tolist():
        for last in range(first + 1, min(first + _LONGEST, steps.size - 1) + 1):
            least = min(abs(steps[first]), abs(steps[last]))
            leaps_back = least > limit and steps[first] * steps[last] < 0
            if leaps_back and abs(read[last + 1] - read[first]) < _BACK * least and not found[first]:
                found[first + 1 : last + 1] = True
                break
    return rows[found]


def zeros(signals: Sequence[tuple[Column, Array]], temperatures: Sequence[Array]) -> Rows:
    """Rows in which every column is 0 in its own unit, a temperature among them that is far from 0 otherwise.

    Loggers write such a row before the first sample, or where the connection was lost.
    """
    nothing = np.all([values == parse_unit(column.unit).offset for column, values in signals], axis=0)
    rows = np.flatnonzero(nothing)
    usual = [np.nanmedian(each) for each in temperatures if np.isfinite(each).any()]
    fallen = [
        abs(each[rows] - middle) > _LEAP * max(1.0, 1.4826 * float(np.nanmedian(abs(each - middle))))
        for each, middle in zip(temperatures, usual, strict=False)
    ]
    return rows[np.any(fallen, axis=0)] if fallen and 2 * rows.size < nothing.size else rows[:0]


def without_slips(
    sheet: Sheet, columns: Sequence[Column], inputs: Mapping[str, Array], readings: Mapping[str, Array]
) -> tuple[dict[str, Array], dict[str, Array], list[str]]:
    """Inputs and readings without such rows, and what is to be said of them.

    A reading is missing there; an input keeps the value before, or in the first row takes the one after.
    """
    inputs, readings = dict(inputs), {name: values.copy() for name, values in readings.items()}
    every = {**inputs, **readings}
    used = [(column, every[column.variable]) for column in columns if column.variable in every]
    temperatures = [readings[c.variable] for c, _ in used if c.variable in readings and "deg" in c.unit]
    remarks = []
    if (empty := zeros(used, temperatures)).size:
        there = np.setdiff1d(np.arange(sheet.cells.shape[0]), empty)
        source = there[np.clip(np.searchsorted(there, empty, side="left") - 1, 0, None)]
        for values in readings.values():
            values[empty] = np.nan
        for name, values in inputs.items():
            inputs[name] = values.copy()
            inputs[name][empty] = values[source]
        told = "taken for missing values, as the logger was not ready or had lost the connection"
        remarks.append(f"{sheet.name}: {_named(sheet, empty)}: nothing but zeros, {told}")
    for column in columns:
        if column.variable in readings and (away := leaping(readings[column.variable])).size:
            values = readings[column.variable]
            near = np.interp(away, *_others(values, away))
            by = float(np.max(np.abs(values[away] - near))) / parse_unit(column.unit).factor
            unit = {"degC": "K", "degF": "degF"}.get(column.unit, column.unit)
            values[away] = np.nan
            remarks.append(
                f"{sheet.name}: {_named(sheet, away)}: {column.name} leaps away and back by up to {by:.3g} "
                f"{unit}, as no heat does; taken for missing values, so look at its wiring"
            )
    return inputs, readings, remarks


def _others(values: Array, away: Rows) -> tuple[Rows, Array]:
    """Rows with a reading that are not among some, and their readings."""
    rows = np.setdiff1d(np.flatnonzero(np.isfinite(values)), away)
    return rows, values[rows]


def _named(sheet: Sheet, rows: Rows) -> str:
    """Which rows of a file, for a sentence."""
    lines = [str(line) for line in sheet.cells.index[rows[:_MOST_NAMED]].tolist()]
    more = f" and {rows.size - _MOST_NAMED} more" if rows.size > _MOST_NAMED else ""
    return f"row{'s' * (rows.size > 1)} {', '.join(lines)}{more}"

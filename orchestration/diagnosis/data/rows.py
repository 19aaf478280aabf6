"""Rows of a log that no machine made: readings that leap away and back at once, and rows of zeros."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.outliers import leap, outliers
from warmlink.orchestration.scenarios.logged.cells import Column, Rows
from warmlink.orchestration.scenarios.logged.sheet import Sheet
from warmlink.orchestration.system.units import parse_unit

_FALLEN = 5.0
"""Multiple of its usual spread by which a temperature differs in a row of zeros."""

_MOST_NAMED = 8


def zeros(signals: Sequence[tuple[Column, Array]], temperatures: Sequence[Array]) -> Rows:
    """Rows in which every column is 0 in its own unit, a temperature among them that is far from 0 otherwise.

    Loggers write such a row before the first sample, or where the connection was lost.
    """
    nothing = np.all([values == parse_unit(column.unit).offset for column, values in signals], axis=0)
    rows = np.flatnonzero(nothing)
    usual = [np.nanmedian(each) for each in temperatures if np.isfinite(each).any()]
    fallen = [
        abs(each[rows] - middle) > _FALLEN * max(1.0, 1.4826 * float(np.nanmedian(abs(each - middle))))
        for each, middle in zip(temperatures, usual, strict=False)
    ]
    return rows[np.any(fallen, axis=0)] if fallen and 2 * rows.size < nothing.size else rows[:0]


def without_slips(
    sheet: Sheet,
    time: Array,
    columns: Sequence[Column],
    inputs: Mapping[str, Array],
    readings: Mapping[str, Array],
) -> tuple[dict[str, Array], dict[str, Array], list[str]]:
    """Inputs and readings without such rows, and what is to be said of them; `time` is in s.

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
    driven = (
        np.flatnonzero(np.any([_leaps(values) for values in inputs.values()], axis=0)) if inputs else None
    )
    for column in columns:
        if column.variable in readings and (away := outliers(time, readings[column.variable], driven)).size:
            values = readings[column.variable]
            by = leap(time, values, away) / parse_unit(column.unit).factor
            unit = {"degC": "K", "degF": "degF"}.get(column.unit, column.unit)
            values[away] = np.nan
            remarks.append(
                f"{sheet.name}: {_named(sheet, away)}: {column.name} leaps away and back by up to {by:.3g} "
                f"{unit}, as no heat does; taken for missing values, so look at its wiring"
            )
    return inputs, readings, remarks


def _leaps(values: Array) -> NDArray[np.bool_]:
    """Whether an input has another value than in the row before, shape (rows,)."""
    return np.append(False, np.diff(np.nan_to_num(values, nan=-1.0)) != 0)


def _named(sheet: Sheet, rows: Rows) -> str:
    """Which rows of a file, for a sentence."""
    lines = [str(line) for line in sheet.cells.index[rows[:_MOST_NAMED]].tolist()]
    more = f" and {rows.size - _MOST_NAMED} more" if rows.size > _MOST_NAMED else ""
    return f"row{'s' * (rows.size > 1)} {', '.join(lines)}{more}"

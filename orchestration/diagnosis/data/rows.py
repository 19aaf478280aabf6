"""Rows of a log that no machine made: rows of zeros, sensors that stick, readings that leap."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.outliers import leap, outliers
from warmlink.orchestration.diagnosis.data.stretches import loose, shifted, stuck
from warmlink.orchestration.scenarios.logged.cells import Column, Rows
from warmlink.orchestration.scenarios.logged.sheet import Sheet
from warmlink.orchestration.system.units import parse_unit

_FALLEN = 5.0
"""Multiple of its usual spread by which a temperature differs in a row of zeros."""

_PULSE, _UNUSUAL, _SHORT = 0.1, 3.0, 3
"""An input's leap in a pulse at least, as a share of its largest and in medians; rows of a short pulse."""

_KELVIN = parse_unit("K")

_MORE, _WARMER = 0.1, 1.0
"""What an input leaps by, at least: a share of its largest value, and a temperature in K."""

_PULSED = "with a pulse of an input that is too short for these rows to follow; taken for missing values"

_UNREAD, _UNREAD_SHARE = 10, 0.05
"""Rows, and share of a run's time, for which it is said that something was not read."""

_MOST_NAMED = 8


def zeros(signals: Sequence[tuple[Column, Array]], temperatures: Sequence[Array]) -> Rows:
    """Rows in which every column is 0 in its own unit, a temperature among them that is far from 0 otherwise.

    Loggers write such a row before the first sample, or where the connection was lost. Empty cells of it say
    nothing.
    """
    nothing = np.all(
        [np.isnan(values) | (values == parse_unit(column.unit).offset) for column, values in signals], axis=0
    )
    rows = np.flatnonzero(nothing)
    read = [(each, np.nanmedian(each)) for each in temperatures if np.isfinite(each).any()]
    fallen = [
        abs(each[rows] - middle) > _FALLEN * max(1.0, 1.4826 * float(np.nanmedian(abs(each - middle))))
        for each, middle in read
    ]
    return rows[np.any(fallen, axis=0)] if fallen and 2 * rows.size < nothing.size else rows[:0]


def without_slips(
    sheet: Sheet,
    time: Array,
    columns: Sequence[Column],
    inputs: Mapping[str, Array],
    readings: Mapping[str, Array],
) -> tuple[dict[str, Array], dict[str, Array], list[str]]:
    """Inputs and readings without rows that no machine made, and what is to be said of them; `time` is in s.

    A reading is missing there; an input keeps the value before, or in the first row takes the one after.
    """
    inputs, readings = dict(inputs), {name: values.copy() for name, values in readings.items()}
    every = {**inputs, **readings}
    used = [(column, every[column.variable]) for column in columns if column.variable in every]
    warm = {column.variable for column in columns if parse_unit(column.unit).exponents == _KELVIN.exponents}
    temperatures = [values for column, values in used if column.variable in readings.keys() & warm]
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
    remarks += _unread(sheet, time, {c.name: readings[c.variable] for c in columns if c.variable in readings})
    leaps = [_leaps(values, name in warm) for name, values in inputs.items()]
    driven = np.flatnonzero(np.any(leaps, axis=0)) if leaps else None
    pulses = np.unique(np.concatenate([np.empty(0, np.intp), *map(_pulses, inputs.values())]))
    for column in (each for each in columns if each.variable in readings):
        remarks += _without_faults(sheet, time, column, readings[column.variable], driven, pulses)
    return inputs, readings, remarks


def _unread(sheet: Sheet, time: Array, readings: Mapping[str, Array]) -> Iterator[str]:
    """Remarks on long stretches of rows in which nothing was read, or one column was not."""
    absent = {name: np.isnan(values) for name, values in readings.items()}
    every = np.all([*absent.values()], axis=0) if absent else np.zeros(time.size, dtype=bool)
    for name, missing in (("nothing", every), *((name, each & ~every) for name, each in absent.items())):
        for rows in _runs_of(np.flatnonzero(missing)):
            lasts = float(time[min(rows[-1] + 1, time.size - 1)] - time[rows[0]])
            if rows.size >= _UNREAD and lasts > _UNREAD_SHARE * time[-1]:
                told = f"{name} was {'' if name == 'nothing' else 'not '}read"
                yield f"{sheet.name}: {told} for {lasts / 60:.3g} min from {time[rows[0]] / 60:.4g} min on"


def _without_faults(
    sheet: Sheet, time: Array, column: Column, values: Array, driven: Rows | None, pulses: Rows
) -> Iterator[str]:
    """Take readings that no temperature made for missing values, and say which; `pulses` may make leaps."""
    unit = {"degC": " K", "1": ""}.get(column.unit, f" {column.unit}")
    missing = "taken for missing values, so look at its wiring"
    for rows in _runs_of(held := stuck(time, values)):
        shown = (values[rows[0]] - parse_unit(column.unit).offset) / parse_unit(column.unit).factor
        minutes = (time[rows[-1]] - time[rows[0]]) / 60
        yield (
            f"{sheet.name}: {_named(sheet, rows)}: {column.name} stays at {shown:.4g} {column.unit} for "
            f"{minutes:.3g} min, as no sensor that works does; {missing}"
        )
    values[held] = np.nan
    for find, told in ((loose, "leaps to and fro"), (outliers, "leaps away and back")):
        every = find(time, values, driven)
        away, pulsed = np.setdiff1d(every, pulses), np.intersect1d(every, pulses)
        for rows, why in ((away, f"as no heat does; {missing}"), (pulsed, _PULSED)):
            if rows.size:
                by = leap(time, values, rows) / parse_unit(column.unit).factor
                which = f"{sheet.name}: {_named(sheet, rows)}: {column.name}"
                yield f"{which} {told} by up to {by:.3g}{unit}, {why}"
        values[every] = np.nan
    for row, height in shifted(time, values, driven):
        by = height / parse_unit(column.unit).factor
        yield (
            f"{sheet.name}: {_named(sheet, np.array([row]))}: from here on {column.name} reads {abs(by):.3g}"
            f"{unit} {'more' if by > 0 else 'less'}, at once, as no heat does: was a sensor or a connector "
            "moved? The readings stay as they are; give what comes before and after as two runs"
        )


def _runs_of(rows: Rows) -> list[Rows]:
    """Rows that follow one another, each stretch by itself."""
    return np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1) if rows.size else []


def _leaps(values: Array, is_temperature: bool) -> NDArray[np.bool_]:
    """Whether an input leaps from the row before, by more than noise, so that readings may; shape (rows,)."""
    moves = np.abs(np.diff(np.nan_to_num(values, nan=-1.0)))
    least = _WARMER if is_temperature else _MORE * float(np.nanmax(np.abs(values), initial=0.0))
    return np.append(False, moves > least)


def _pulses(values: Array) -> Rows:
    """Rows in which an input is on, or off, for a few rows only, and the rows after each."""
    moves = np.abs(np.diff(np.nan_to_num(values, nan=-1.0)))
    usual = max(_PULSE * float(np.max(moves, initial=0.0)), _UNUSUAL * float(np.median(moves)), 1e-12)
    leaps = np.flatnonzero(moves > usual) + 1
    short = leaps[:-1][np.diff(leaps) <= _SHORT]
    return np.unique(short[:, None] + np.arange(_SHORT + 1))


def _named(sheet: Sheet, rows: Rows) -> str:
    """Which rows of a file, for a sentence."""
    lines: list[str] = []
    for each in (sheet.cells.index[stretch].tolist() for stretch in _runs_of(rows)):
        lines += map(str, each) if len(each) <= _SHORT else [f"{each[0]} to {each[-1]}"]
    more = f" and {len(lines) - _MOST_NAMED} more" if len(lines) > _MOST_NAMED else ""
    return f"row{'s' * (rows.size > 1)} {', '.join(lines[:_MOST_NAMED])}{more}"

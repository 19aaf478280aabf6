"""A measured run: its inputs, its readings, and what was understood of its file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError, refusal
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.columns import Assignment
from warmlink.orchestration.diagnosis.data.options import DEFAULT_OPTIONS, ReadOptions
from warmlink.orchestration.diagnosis.data.rows import without_slips
from warmlink.orchestration.diagnosis.data.signals import as_reading
from warmlink.orchestration.scenarios.logged.cells import Column, as_input
from warmlink.orchestration.scenarios.logged.clock import times
from warmlink.orchestration.scenarios.logged.layout import TIME, converts
from warmlink.orchestration.scenarios.logged.sheet import Place, Sheet, read_sheet

if TYPE_CHECKING:
    import pandas as pd

    from warmlink.orchestration.machine.rig import Rig

FEWEST_ROWS = 20
"""Rows with a reading; fewer say nothing about noise."""

MOST_DAYS = 100.0
"""That a run may last; each step of a longer one would have to be simulated."""

MOST_ROWS = 200_000
"""Rows that are kept; of a longer file groups of rows are averaged."""

_MOST_NAMED = 8
"""Variables that a sentence names."""

_GAP = 3.0
"""Usual spacings of the rows from which on a pause counts as a gap."""

_PAUSE = 120.0
"""s; what a machine did in a shorter gap of the log is hardly seen."""


@dataclass(frozen=True)
class Run:
    """One run in SI units.

    Attributes
    ----------
    time : s from the start of the run, shape (n,), rising
    inputs : signal held until the next row by input, shape (n,); NaN where the pad is off
    readings : measured values by output, shape (n,); NaN where there is none
    covariates : columns that only a cause may use, by the input that it would feed
    scatter : 1 sigma by which each row of an input is off by itself, as a thermometer's reading is
    labels, known : what the experiment says of this run
    heldout : whether it is kept from fitting and choosing
    fit_until : s; rows from here on are held out
    adapt : s; the opening part of a held-out run from which its own unknowns may be estimated
    unused : headers of columns that nothing is made of
    absent : sentence by name that was given to a column which the file lacks
    remarks : on cells that were taken for missing values
    columns : that were used, inputs first
    form : how the file is written, and what its times are
    """

    name: str
    time: Array
    inputs: Mapping[str, Array]
    readings: Mapping[str, Array]
    covariates: Mapping[str, Array] = field(default_factory=dict)
    scatter: Mapping[str, float] = field(default_factory=dict)
    labels: Mapping[str, str] = field(default_factory=dict)
    known: Mapping[str, float] = field(default_factory=dict)
    heldout: bool = False
    fit_until: float = np.inf
    adapt: float = 0.0
    unused: tuple[str, ...] = ()
    absent: Mapping[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    columns: tuple[Column, ...] = ()
    form: str = ""

    @property
    def fitted(self) -> NDArray[np.bool_]:
        """Rows that fitting and choosing may use, shape (n,)."""
        return np.zeros(self.time.size, dtype=bool) if self.heldout else self.time < self.fit_until

    @property
    def ambient(self) -> Array | None:
        """Logged ambient temperature in K, shape (n,); None if there is none."""
        return next((v for name, v in self.inputs.items() if name.endswith("ambient_temperature")), None)

    @property
    def measured(self) -> tuple[Column, ...]:
        """Columns of readings, in the order of the file."""
        return tuple(column for column in self.columns if column.variable in self.readings)

    @property
    def gaps(self) -> NDArray[np.bool_]:
        """Whether a pause of the log follows each row but the last, shape (n - 1,)."""
        spacing = np.diff(self.time)
        return np.asarray(spacing > _GAP * np.median(spacing))

    @property
    def pauses(self) -> NDArray[np.intp]:
        """Rows after which the log pauses for so long that what the machine did then matters.

        A row without readings was written down by somebody who knew what the machine did until the next one.
        """
        read = np.any([np.isfinite(each[:-1]) for each in self.readings.values()], axis=0)
        return np.flatnonzero(self.gaps & read & (np.diff(self.time) > _PAUSE))

    def understood(self) -> dict[str, Any]:
        """What the run was understood to be, as JSON."""
        spacing = np.diff(self.time)
        usual = float(np.median(spacing))
        gaps = np.flatnonzero(self.gaps)
        said = ("variable", "unit", "unit_from", "filled", "cells", "least", "largest")
        return {
            "name": self.name,
            "form": self.form,
            "rows": int(self.time.size),
            "duration_s": float(self.time[-1]),
            "spacing_s": usual,
            "gaps": [{"at_s": float(self.time[i]), "lasts_s": float(spacing[i])} for i in gaps],
            "held_out": self.heldout,
            "columns": [{"column": c.header, **{k: getattr(c, k) for k in said}} for c in self.columns],
            "not_used": list(self.unused),
        }

    def row_at(self, times: NDArray[np.floating]) -> NDArray[np.intp]:
        """Row whose inputs act at each time in s, shape of `times`."""
        return np.clip(np.searchsorted(self.time, times, side="right") - 1, 0, self.time.size - 1)

    def part(self, rows: NDArray[np.bool_]) -> Run:
        """The run with some of its rows."""
        inputs, readings, covariates = (
            {name: values[rows] for name, values in signals.items()}
            for signals in (self.inputs, self.readings, self.covariates)
        )
        return replace(self, time=self.time[rows], inputs=inputs, readings=readings, covariates=covariates)

    def sooner(self, row: int, share: float) -> Run:
        """The run with a further row of the same inputs, a share of the time from the row before sooner."""
        after_it = (1 - 1e-6) * (self.time[row] - self.time[row - 1])  # no two rows have one time
        time = np.insert(self.time, row, self.time[row] - share * after_it)
        inputs = {name: np.insert(signal, row, signal[row]) for name, signal in self.inputs.items()}
        covariates = {name: np.insert(signal, row, signal[row]) for name, signal in self.covariates.items()}
        readings = {name: np.insert(values, row, np.nan) for name, values in self.readings.items()}
        return replace(self, time=time, inputs=inputs, covariates=covariates, readings=readings)

    def like(self, other: Run) -> bool:
        """Whether the other has the same readings at the same times."""
        return (
            np.array_equal(self.time, other.time)
            and self.readings.keys() == other.readings.keys()
            and all(np.array_equal(v, other.readings[k], equal_nan=True) for k, v in self.readings.items())
        )


def read_run(
    source: Path | pd.DataFrame,
    rig: Rig,
    channels: Mapping[str, str] | None = None,
    covariates: Mapping[str, str] | None = None,
    options: ReadOptions = DEFAULT_OPTIONS,
) -> Run:
    """Read a run.

    Parameters
    ----------
    source : a file as loggers and spreadsheets write them, or a DataFrame
    rig : the system it was measured on
    channels : variable by column header, beside the columns that the rig names; without any, a column that
        may be what the run lacks is refused
    covariates : input by header of a column that only causes may use
    options : units and names of columns that the user gave

    Raises
    ------
    InputError
        The file, a header or a cell does not fit.
    """
    sheet = read_sheet(source, options.decimal, [h for h, name in options.names.items() if name == TIME])
    extra = covariates or {}
    assigned = Assignment(sheet, rig, options, channels or {}, extra)
    clock, date = assigned.time()
    wrong, time, taken = list[str](), np.empty(0), ""
    try:
        time, taken = times(sheet, clock, date)
        _refuse_too_short_or_long(sheet, clock, time)
    except InputError as fault:
        wrong.append(str(fault))
    found: dict[str, dict[str, Array]] = {"input": {}, "reading": {}, "covariate": {}}
    columns, remarks = {kind: list[Column]() for kind in found}, list[str]()
    for place in assigned.signals():
        kind = "covariate" if place.variable in extra.values() else _kind(sheet, place, rig)
        try:
            column, found[kind][place.variable], said = _read(sheet, place, rig, kind)
        except InputError as fault:
            wrong.append(str(fault))
            continue
        columns[kind].append(column)
        remarks += said
    if wrong:
        raise refusal(wrong)
    _refuse_empty(sheet.name, found["reading"], assigned, rig)
    used = tuple(each for kind in columns.values() for each in kind)
    inputs, readings, slips = without_slips(sheet, time, used, found["input"], found["reading"])
    run = Run(
        source.stem if isinstance(source, Path) else "data",
        time,
        inputs,
        readings,
        found["covariate"],
        unused=assigned.unused,
        absent=assigned.absent,
        remarks=(*remarks, *slips),
        columns=used,
        form=f"{sheet.form}; times as {taken}",
    )
    return condensed(run, [name for name in run.inputs if rig.variables[name].is_discrete])


def _read(sheet: Sheet, place: Place, rig: Rig, kind: str) -> tuple[Column, Array, list[str]]:
    """A column, its values, and remarks on its cells; raises InputError."""
    scalar = rig.variables.get(place.variable)
    si = rig.unit(place.variable) if kind == "input" else "W"
    if si != "W" and converts(place.unit or "", "W"):
        raise InputError(
            f"{sheet.of(place.column)}: is a power in {place.unit}, and {place.variable} is in {si}; let it "
            'drive a [term.NAME] with heat = "power" and inputs = { power = "0 W" }, as "NAME.power"'
        )
    return as_reading(sheet, place, scalar) if kind == "reading" else as_input(sheet, place, scalar)


def _refuse_too_short_or_long(sheet: Sheet, clock: Place, time: Array) -> None:
    """Raise InputError where there are too few rows, or the run lasts too long; `clock` is its column."""
    if time.size < FEWEST_ROWS:
        raise InputError(f"{sheet.name}: only {time.size} rows; a diagnosis needs at least {FEWEST_ROWS}")
    days = time[-1] / 86400
    if not days <= MOST_DAYS:
        raise InputError(
            f"{sheet.of(clock.column)}: the run lasts {days:.4g} days; at most {MOST_DAYS:g} can be "
            "simulated, so correct the unit or give a part of it"
        )


def _kind(sheet: Sheet, place: Place, rig: Rig) -> str:
    """Whether a column is an input or a reading; raises InputError where it is a parameter."""
    scalar = rig.scalar(place.variable, sheet.of(place.column))
    if place.variable in rig.externals:
        return "input"
    if scalar.start is None:
        return "reading"
    raise InputError(
        f"{sheet.of(place.column)}: {place.variable} is neither an input nor an output; "
        "give a constant under [known]"
    )


def condensed(run: Run, discrete: Sequence[str] = (), most: int = MOST_ROWS) -> Run:
    """Average a run's rows in groups of equal size where there are more than can be used.

    A discrete input keeps the value of the first row throughout a group, and so does a pad that is off.
    """
    if run.time.size <= most:
        return run
    import pandas as pd

    group, place = np.divmod(np.arange(run.time.size), -(-run.time.size // most))
    first = run.part(place == 0)

    def mean(values: Array) -> Array:
        return pd.Series(values).groupby(group).mean().to_numpy()

    def steady(values: Array, held: Array) -> Array:
        return np.where(np.isfinite(held), mean(values), np.nan)

    inputs = {n: v if n in discrete else steady(run.inputs[n], v) for n, v in first.inputs.items()}
    readings = {n: mean(v) for n, v in run.readings.items()}
    covariates = {n: steady(run.covariates[n], v) for n, v in first.covariates.items()}
    return replace(first, inputs=inputs, readings=readings, covariates=covariates)


def _refuse_empty(name: str, readings: Mapping[str, Array], assigned: Assignment, rig: Rig) -> None:
    if not readings:
        known = f", and may be among {', '.join(map(repr, assigned.unused))}" if assigned.unused else ""
        raise InputError(
            f"{name}: no measured column is known{known}; give at least one of "
            f"{', '.join(rig.measurable[:_MOST_NAMED])}, and say which is which with {assigned.offers()}"
        )
    most = max(int(np.isfinite(values).sum()) for values in readings.values())
    if most < FEWEST_ROWS:
        raise InputError(
            f"{name}: its measured columns hold at most {most} values; at least {FEWEST_ROWS} are needed"
        )


def names_of(columns: Sequence[Column]) -> dict[str, str]:
    """Column name by variable."""
    return {column.variable: column.name for column in columns}


def over_steps(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Means from each row to the next, shape as given: a row holds until the next, and a reading does not."""
    return np.append((values[1:] + values[:-1]) / 2, values[-1])

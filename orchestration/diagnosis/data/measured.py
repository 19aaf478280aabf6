"""A measured run from a CSV file: which column is which input or output."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.diagnosis.data.table import (
    FEWEST_ROWS,
    TIME,
    column,
    held,
    is_time,
    read_table,
    refuse_implausible,
    refuse_undefined,
    require,
    times,
)
from warmlink.orchestration.diagnosis.data.values import is_discrete, is_temperature
from warmlink.orchestration.scenarios.quantity import heading

if TYPE_CHECKING:
    import pandas as pd

    from warmlink.orchestration.diagnosis.data.rig import Rig

Vector = NDArray[np.float64]

MOST_ROWS = 200_000
"""Rows that are kept; of a longer file groups of rows are averaged."""


@dataclass(frozen=True)
class Column:
    """A column of the file that is used: its name, its unit as people read it, and the variable it is."""

    name: str
    unit: str
    variable: str


@dataclass(frozen=True)
class Run:
    """One run in SI units.

    Attributes
    ----------
    time : s from the start of the run, shape (n,), rising
    inputs : signal held until the next row by input, shape (n,); NaN where the pad is off
    readings : measured values by output, shape (n,); NaN where there is none
    covariates : columns that only a cause may use, by the input that it would feed
    labels, known : what the experiment says of this run
    heldout : whether it is kept from fitting and choosing
    fit_until : s; rows from here on are held out
    adapt : s; the opening part of a held-out run from which its own unknowns may be estimated
    unused : headers of columns that nothing is made of
    """

    name: str
    time: Vector
    inputs: Mapping[str, Vector]
    readings: Mapping[str, Vector]
    covariates: Mapping[str, Vector] = field(default_factory=dict)
    labels: Mapping[str, str] = field(default_factory=dict)
    known: Mapping[str, float] = field(default_factory=dict)
    heldout: bool = False
    fit_until: float = np.inf
    adapt: float = 0.0
    unused: tuple[str, ...] = ()

    @property
    def fitted(self) -> NDArray[np.bool_]:
        """Rows that fitting and choosing may use, shape (n,)."""
        return np.zeros(self.time.size, dtype=bool) if self.heldout else self.time < self.fit_until

    @property
    def ambient(self) -> Vector | None:
        """Logged ambient temperature in K, shape (n,); None where there is none."""
        return next((v for name, v in self.inputs.items() if name.endswith("ambient_temperature")), None)

    def row_at(self, times: NDArray[np.floating]) -> NDArray[np.intp]:
        """Row whose inputs act at each time in s, shape of `times`."""
        return np.clip(np.searchsorted(self.time, times, side="right") - 1, 0, self.time.size - 1)

    def part(self, rows: NDArray[np.bool_]) -> Run:
        """The run with some of its rows."""

        def chosen(signals: Mapping[str, Vector]) -> dict[str, Vector]:
            return {name: values[rows] for name, values in signals.items()}

        return replace(
            self,
            time=self.time[rows],
            inputs=chosen(self.inputs),
            readings=chosen(self.readings),
            covariates=chosen(self.covariates),
        )

    def like(self, other: Run) -> bool:
        """Whether the other has the same readings at the same times."""
        return (
            np.array_equal(self.time, other.time)
            and self.readings.keys() == other.readings.keys()
            and all(np.array_equal(v, other.readings[k], equal_nan=True) for k, v in self.readings.items())
        )


def read_run(
    path: Path,
    rig: Rig,
    channels: Mapping[str, str] | None = None,
    covariates: Mapping[str, str] | None = None,
) -> tuple[Run, tuple[Column, ...]]:
    """Read a run.

    Parameters
    ----------
    path : the CSV file
    rig : the system it was measured on
    channels : variable by column header, beside the columns that the rig names; without any, a column that
        the rig does not name is refused
    covariates : input by header of a column that only causes may use

    Returns
    -------
    Run, tuple of Column
        The run, and its measured columns in the order of the file.

    Raises
    ------
    InputError
        The file, a header or a cell does not fit.
    """
    table = read_table(path)
    time = times(path, table)
    inputs: dict[str, Vector] = {}
    readings: dict[str, Vector] = {}
    extra: dict[str, Vector] = {}
    columns: list[Column] = []
    discrete: list[str] = []
    wanted = _wanted(path, table, rig, channels or {}, covariates or {})
    for header, variable in wanted.items():
        scalar = rig.scalar(variable, f"{path.name}: column {header!r}")
        values, unit = column(path, table, header, scalar.variable.unit, is_temperature(scalar))
        if variable in rig.externals:
            if is_discrete(scalar):
                refuse_undefined(path, header, values, scalar)
                discrete.append(variable)
            inputs[variable] = held(path, header, values, empty_is_off=variable.endswith("pad_temperature"))
        elif scalar.start is None:
            refuse_implausible(path, header, values, scalar.variable.unit)
            readings[variable] = values
            columns.append(Column(heading(header)[0], unit, variable))
        else:
            raise InputError(
                f"{path.name}: column {header!r}: {variable} is neither an input nor an output; "
                "give a constant under [known]"
            )
    for header, variable in (covariates or {}).items():
        require(path, table, header)
        values, _ = column(path, table, header, "K", True)
        extra[variable] = held(path, header, values, empty_is_off=False)
    _refuse_empty(path, readings)
    used = {*wanted, *(covariates or {})}
    unused = tuple(h for h in map(str, table.columns) if h not in used and not is_time(h))
    run = Run(path.stem, time, inputs, readings, extra, unused=unused)
    return condensed(run, discrete), tuple(columns)


def condensed(run: Run, discrete: Sequence[str] = (), most: int = MOST_ROWS) -> Run:
    """Average a run's rows in groups of equal size where there are more than can be used.

    A discrete input keeps the value of the first row throughout a group, and so does a pad that is off.
    """
    if run.time.size <= most:
        return run
    starts = np.arange(0, run.time.size, -(-run.time.size // most))

    def mean(values: Vector) -> Vector:
        full = np.isfinite(values)
        count = np.add.reduceat(full.astype(float), starts)
        sums = np.add.reduceat(np.where(full, values, 0.0), starts)
        return np.where(count > 0, sums / np.maximum(count, 1.0), np.nan)

    def steady(values: Vector) -> Vector:
        return np.where(np.isfinite(values[starts]), mean(values), np.nan)

    return replace(
        run,
        time=run.time[starts],
        inputs={
            name: values[starts] if name in discrete else steady(values)
            for name, values in run.inputs.items()
        },
        readings={name: mean(values) for name, values in run.readings.items()},
        covariates={name: steady(values) for name, values in run.covariates.items()},
    )


def _wanted(
    path: Path, table: pd.DataFrame, rig: Rig, channels: Mapping[str, str], covariates: Mapping[str, str]
) -> Mapping[str, str]:
    """Variable by header, from the experiment's channels and from the rig's names of columns."""
    for header in channels:
        require(path, table, header)
    wanted = dict(channels)
    for header in map(str, table.columns):
        name, unit = heading(header)
        if header in channels or header in covariates or is_time(header):
            continue
        if unit is None and (name in rig.columns or not channels):
            raise InputError(
                f"{path.name}: column {header!r} has no unit; head it as `name [unit]`, e.g. 'time [s]'"
            )
        if name not in rig.columns and not channels:
            raise InputError(
                f"{path.name}: column {header!r} is not known; "
                f"{instead(name, (TIME, *rig.columns), 'or name it in an experiment file')}"
            )
        if name in rig.columns and rig.columns[name] not in channels.values():
            wanted[header] = rig.columns[name]
    headers = list(wanted)
    for i, (header, variable) in enumerate(wanted.items()):
        other = next((h for h in headers[:i] if wanted[h] == variable), None)
        if other is not None:
            raise InputError(f"{path.name}: columns {other!r} and {header!r} are both {variable}; keep one")
    return wanted


def _refuse_empty(path: Path, readings: Mapping[str, Vector]) -> None:
    if not readings:
        raise InputError(f"{path.name}: no measured column; give at least one temperature or the elongation")
    most = max(int(np.isfinite(values).sum()) for values in readings.values())
    if most < FEWEST_ROWS:
        raise InputError(
            f"{path.name}: its measured columns hold at most {most} values; at least {FEWEST_ROWS} are needed"
        )


def names_of(columns: Sequence[Column]) -> dict[str, str]:
    """Column name by variable."""
    return {column.variable: column.name for column in columns}

"""A measured run from a CSV file: columns headed `name [unit]`, in SI.

Cells may be empty, times uneven. What does not fit is refused with its row (the line of the file) and
column.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.diagnosis.values import column_parts, converter, is_temperature

if TYPE_CHECKING:
    import pandas as pd

    from warmlink.orchestration.diagnosis.rigs import Rig

Vector = NDArray[np.float64]

TIME = "time"
MOST_ROWS = 200_000
"""Rows that are kept; of a longer file groups of rows are averaged."""

FEWEST_ROWS = 20
"""Rows with a reading; fewer say nothing about noise."""

MOST_PLAUSIBLE = {"K": (150.0, 1500.0), "m": (-0.01, 0.01)}
"""Range of a credible reading by SI unit, to catch a wrong unit in the header."""


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

    @property
    def fitted(self) -> NDArray[np.bool_]:
        """Rows that fitting and choosing may use, shape (n,)."""
        return np.zeros(self.time.size, dtype=bool) if self.heldout else self.time < self.fit_until

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
    channels : variable by column header; None: the columns that the rig names, and no others
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
    table = _read_table(path)
    time = _times(path, table)
    inputs: dict[str, Vector] = {}
    readings: dict[str, Vector] = {}
    extra: dict[str, Vector] = {}
    columns: list[Column] = []
    for header, variable in _wanted(path, table, rig, channels).items():
        scalar = rig.scalar(variable, f"{path.name}: column {header!r}")
        values, unit = _column(path, table, header, scalar.variable.unit, is_temperature(scalar))
        if variable in rig.externals:
            inputs[variable] = _held(path, header, values, empty_is_off=variable.endswith("pad_temperature"))
        elif scalar.start is None:
            _refuse_implausible(path, header, values, scalar.variable.unit)
            readings[variable] = values
            columns.append(Column((column_parts(header) or (header,))[0], unit, variable))
        else:
            raise InputError(
                f"{path.name}: column {header!r}: {variable} is neither an input nor an output; "
                "give a constant under [known]"
            )
    for header, variable in (covariates or {}).items():
        _require(path, table, header)
        values, _ = _column(path, table, header, "K", True)
        extra[variable] = _held(path, header, values, empty_is_off=False)
    _refuse_empty(path, readings)
    return condensed(Run(path.stem, time, inputs, readings, extra)), tuple(columns)


def condensed(run: Run, most: int = MOST_ROWS) -> Run:
    """Average a run's rows in groups of equal size where there are more than can be used.

    A pad that is off in the first row of a group is off in the group.
    """
    if run.time.size <= most:
        return run
    starts = np.arange(0, run.time.size, -(-run.time.size // most))

    def mean(values: Vector) -> Vector:
        full = np.isfinite(values)
        count = np.add.reduceat(full.astype(float), starts)
        sums = np.add.reduceat(np.where(full, values, 0.0), starts)
        return np.where(count > 0, sums / np.maximum(count, 1.0), np.nan)

    def held(values: Vector) -> Vector:
        return np.where(np.isfinite(values[starts]), mean(values), np.nan)

    return replace(
        run,
        time=run.time[starts],
        inputs={name: held(values) for name, values in run.inputs.items()},
        readings={name: mean(values) for name, values in run.readings.items()},
        covariates={name: held(values) for name, values in run.covariates.items()},
    )


def _read_table(path: Path) -> pd.DataFrame:
    import pandas as pd

    if not path.is_file():
        raise InputError(f"{path}: there is no such file; give the path of a CSV file")
    try:
        table = pd.read_csv(path, skipinitialspace=True, skip_blank_lines=False, low_memory=False)
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as fault:
        reason = str(fault).strip().splitlines()[-1]
        raise InputError(
            f"{path.name}: cannot be read as CSV ({reason}); give commas and a header row"
        ) from fault
    twice = [name for name in table.columns if name.rpartition(".")[0] in table.columns]
    if twice:
        raise InputError(f"{path.name}: column {twice[0].rpartition('.')[0]!r} stands twice; keep one")
    return table


def _wanted(
    path: Path, table: pd.DataFrame, rig: Rig, channels: Mapping[str, str] | None
) -> Mapping[str, str]:
    if channels is not None:
        for header in channels:
            _require(path, table, header)
        return channels
    wanted = {}
    for header in map(str, table.columns):
        parts = column_parts(header)
        if parts is None:
            raise InputError(
                f"{path.name}: column {header!r} has no unit; head it as `name [unit]`, e.g. 'time [s]'"
            )
        if parts[0] == TIME:
            continue
        if parts[0] not in rig.columns:
            raise InputError(
                f"{path.name}: column {header!r} is not known; "
                f"{instead(parts[0], (TIME, *rig.columns), 'or name it in an experiment file')}"
            )
        wanted[header] = rig.columns[parts[0]]
    return wanted


def _require(path: Path, table: pd.DataFrame, header: str) -> None:
    if header not in table.columns:
        raise InputError(
            f"{path.name}: there is no column {header!r}; {instead(header, map(str, table.columns))}"
        )


def _times(path: Path, table: pd.DataFrame) -> Vector:
    headers = [h for h in map(str, table.columns) if (column_parts(h) or ("",))[0] == TIME]
    if not headers:
        raise InputError(f"{path.name}: there is no time column; head it as 'time [s]'")
    values, _ = _column(path, table, headers[0], "s", False)
    empty = np.flatnonzero(~np.isfinite(values))
    if empty.size:
        raise InputError(f"{path.name}: row {empty[0] + 2}, column {headers[0]!r}: the time is missing")
    back = np.flatnonzero(np.diff(values) <= 0)
    if back.size:
        row = int(back[0]) + 1
        raise InputError(
            f"{path.name}: row {row + 2}, column {headers[0]!r}: {values[row]:g} s comes after "
            f"{values[row - 1]:g} s; times must increase"
        )
    if values.size < FEWEST_ROWS:
        raise InputError(f"{path.name}: only {values.size} rows; a diagnosis needs at least {FEWEST_ROWS}")
    return values - values[0]


def _column(
    path: Path, table: pd.DataFrame, header: str, si_unit: str, temperature: bool
) -> tuple[Vector, str]:
    """Values of a column in SI, and the unit that the file has them in."""
    import pandas as pd

    parts = column_parts(header)
    if parts is None:
        raise InputError(f"{path.name}: column {header!r} has no unit; head it as `name [unit]`")
    conversion = converter(parts[1], si_unit, not temperature, f"{path.name}: column {header!r}")
    cells: Any = table[header]
    numbers = pd.to_numeric(cells, errors="coerce")
    wrong = np.flatnonzero((numbers.isna() & cells.notna()).to_numpy())
    wrong = np.array([i for i in wrong[:100] if str(cells.iloc[i]).strip()], dtype=int)
    if wrong.size:
        raise InputError(
            f"{path.name}: row {wrong[0] + 2}, column {header!r}: {str(cells.iloc[wrong[0]])!r} is not a "
            "number; correct it or leave the cell empty"
        )
    values = numbers.to_numpy(dtype=float)
    endless = np.flatnonzero(np.isinf(values))
    if endless.size:
        raise InputError(f"{path.name}: row {endless[0] + 2}, column {header!r}: the value is not finite")
    return conversion.factor * values + conversion.offset, parts[1]


def _held(path: Path, header: str, values: Vector, empty_is_off: bool) -> Vector:
    """Fill empty cells with the last value; those of a pad stay empty, which is off."""
    if empty_is_off:
        return values
    filled = np.isfinite(values)
    if not filled.any():
        raise InputError(f"{path.name}: column {header!r} is empty; give the input or leave the column out")
    if not filled[0]:
        raise InputError(f"{path.name}: row 2, column {header!r}: an input needs a value in the first row")
    last = np.maximum.accumulate(np.where(filled, np.arange(values.size), 0))
    return values[last]


def _refuse_implausible(path: Path, header: str, values: Vector, unit: str) -> None:
    low, high = MOST_PLAUSIBLE.get(unit, (-np.inf, np.inf))
    with np.errstate(invalid="ignore"):
        share = float(np.mean((values < low) | (values > high)))
    if share > 0.5:
        middle = float(np.nanmedian(values))
        raise InputError(
            f"{path.name}: column {header!r}: half of the values lie about {middle:.4g} {unit}, outside "
            f"{low:g} to {high:g} {unit}; the unit in the header seems wrong"
        )


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

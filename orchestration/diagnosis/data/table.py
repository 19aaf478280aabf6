"""A CSV file of measurements as a table: columns headed `name [unit]`, in SI.

What does not fit is refused with its row (the line of the file) and column.
"""

from __future__ import annotations

from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component import limits
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.scenarios.quantity import converter, heading
from warmlink.orchestration.text_files import MOST_SHOWN, is_file, measured_text, shown

if TYPE_CHECKING:
    import pandas as pd

    from warmlink.fmus.component import Scalar

Vector = NDArray[np.float64]

TIME = "time"

FEWEST_ROWS = 20
"""Rows with a reading; fewer say nothing about noise."""

MOST_DAYS = 100.0
"""That a run may last; each step of a longer one would have to be simulated."""

MOST_PLAUSIBLE = {"K": (150.0, 1500.0), "m": (-0.01, 0.01)}
"""Range of a credible reading by SI unit, to catch a wrong unit in the header."""


def read_table(path: Path) -> pd.DataFrame:
    """Cells of a CSV file as text, their headers unique; raises InputError where it is none."""
    import pandas as pd

    if not is_file(path):
        raise InputError(f"{path}: there is no such file; give the path of a CSV file")
    try:
        # As text: whatever is no number is then named with its row, whatever pandas would make of it.
        table = pd.read_csv(
            StringIO(measured_text(path)), skipinitialspace=True, skip_blank_lines=False, dtype=str
        )
    except (pd.errors.ParserError, pd.errors.EmptyDataError) as fault:
        reason = str(fault).strip().splitlines()[-1]
        raise InputError(
            f"{path.name}: cannot be read as CSV ({reason}); give commas and a header row"
        ) from fault
    for name in map(str, table.columns):
        if len(name) > MOST_SHOWN:
            raise InputError(
                f"{path.name}: column {shown(name)} is too long for `name [unit]`; give commas and headers"
            )
    twice = [name for name in table.columns if name.rpartition(".")[0] in table.columns]
    if twice:
        raise InputError(f"{path.name}: column {twice[0].rpartition('.')[0]!r} stands twice; keep one")
    return table


def is_time(header: str) -> bool:
    """Whether a header is that of the time."""
    name, unit = heading(header)
    return name == TIME and unit is not None


def require(path: Path, table: pd.DataFrame, header: str) -> None:
    """Raise InputError where there is no such column."""
    if header not in table.columns:
        raise InputError(
            f"{path.name}: there is no column {header!r}; {instead(header, map(str, table.columns))}"
        )


def times(path: Path, table: pd.DataFrame) -> Vector:
    """Times in s from the first row; raises InputError where they are missing or do not increase."""
    headers = [h for h in map(str, table.columns) if is_time(h)]
    if not headers:
        raise InputError(f"{path.name}: there is no time column; head it as 'time [s]'")
    if len(headers) > 1:
        raise InputError(f"{path.name}: columns {headers[0]!r} and {headers[1]!r} are both times; keep one")
    values, _ = column(path, table, headers[0], "s", False)
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
    days = (values[-1] - values[0]) / 86400
    if not days <= MOST_DAYS:
        raise InputError(
            f"{path.name}: column {headers[0]!r}: the run lasts {days:.4g} days; at most "
            f"{MOST_DAYS:g} can be simulated, so correct the unit or give a part of it"
        )
    return values - values[0]


def column(
    path: Path, table: pd.DataFrame, header: str, si_unit: str, temperature: bool
) -> tuple[Vector, str]:
    """Values of a column in SI, NaN where a cell is empty, and the unit that the file has them in.

    Raises
    ------
    InputError
        The header has no unit or one of another quantity, or a cell is no finite number.
    """
    import pandas as pd

    _, unit = heading(header)
    if unit is None:
        raise InputError(f"{path.name}: column {header!r} has no unit; head it as `name [unit]`")
    conversion = converter(unit, si_unit, f"{path.name}: column {header!r}", difference=not temperature)
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
        raise InputError(
            f"{path.name}: row {endless[0] + 2}, column {header!r}: the value is not finite; "
            "correct it or leave the cell empty"
        )
    return conversion.factor * values + conversion.offset, unit


def held(path: Path, header: str, values: Vector, empty_is_off: bool) -> Vector:
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


def refuse_undefined(path: Path, header: str, values: Vector, scalar: Scalar) -> None:
    """Raise InputError where a cell is not a value of a discrete input, as 1.5 for the pad's mode."""
    for row in np.flatnonzero(np.isfinite(values)):
        sentence = limits.problem(scalar, float(values[row]))
        if sentence is not None:
            raise InputError(f"{path.name}: row {row + 2}, column {header!r}: {sentence}")


def refuse_implausible(path: Path, header: str, values: Vector, unit: str) -> None:
    """Raise InputError where half of the readings cannot be in the SI unit that the header leads to."""
    low, high = MOST_PLAUSIBLE.get(unit, (-np.inf, np.inf))
    with np.errstate(invalid="ignore"):
        share = float(np.mean((values < low) | (values > high)))
    if share > 0.5:
        middle = float(np.nanmedian(values))
        raise InputError(
            f"{path.name}: column {header!r}: half of the values lie about {middle:.4g} {unit}, outside "
            f"{low:g} to {high:g} {unit}; the unit in the header seems wrong"
        )

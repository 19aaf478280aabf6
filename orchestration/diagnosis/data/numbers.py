"""Numbers in a column of cells, and the cells that hold none: what a logger writes where it reads nothing."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.layout import NUMBER
from warmlink.orchestration.diagnosis.data.sheet import DECIMALS, Sheet
from warmlink.orchestration.text_files import shown

OVERRANGE = 1e30
"""From here on a number stands for "no reading": 9.9E37, 1e99 and infinity are written for an overload."""

_MARKS = (999.0, 999.9, 999.99, 9999.0, 9999.9, 99999.0, 999999.0, 32767.0, 32768.0, 65535.0)
"""Numbers that stand for "no reading", where all others in the column are far smaller."""

_FAR = 3.0

_FEWEST_CHANGES = 5
"""Changes of a column with which it may be said to repeat itself: below, it is as good as dead."""

_LEAP, _LASTING = 4.0, 3
"""Change from row to row that is a jump, as a multiple of those that noise makes; rows that make a level."""


def numbers(sheet: Sheet, column: int) -> tuple[Array, NDArray[np.intp]]:
    """Numbers of a column in its own unit, without the words and numbers that stand for "no reading".

    Returns
    -------
    tuple of numpy.ndarray
        Values, NaN where a cell is empty or holds none, shape (rows,), and the rows of cells that hold
        something that is no reading.

    Raises
    ------
    InputError
        A cell may be read in two ways, looks like a number and is none, or most cells are words.
    """
    cells: Any = sheet.cells[column]
    if cells.dtype.kind in "iufb":
        values, words = cells.to_numpy(dtype=float, na_value=np.nan).copy(), np.flatnonzero([])
    else:
        values, words = _of_text(sheet, column)
    size = np.abs(values)
    marks = np.isin(size, _MARKS)
    usual = float(np.nanmax(np.where(marks | (size >= OVERRANGE), 0.0, size), initial=0.0))
    none = np.flatnonzero((size >= OVERRANGE) | (marks & (size > _FAR * usual)))
    values[none] = np.nan
    return values, np.union1d(words, none)


def cell_shown(sheet: Sheet, row: int, column: int) -> str:
    """A cell as a sentence shows it."""
    return shown(str(sheet.cells[column].iloc[row]))


def _of_text(sheet: Sheet, column: int) -> tuple[Array, NDArray[np.intp]]:
    """Numbers of cells that are text, NaN where there is none, and the rows of words."""
    import pandas as pd

    cells: Any = sheet.cells[column]
    text = cells.astype(str).str.strip().where(cells.notna(), "").astype(object)
    mark = DECIMALS.get(sheet.decimal, "")
    doubtful = text.str.contains("." if mark == "," else ",", regex=False).to_numpy(dtype=bool)
    plain = text.str.replace(",", ".", regex=False) if mark == "," else text.copy()
    for row in np.flatnonzero(doubtful).tolist():
        plain.iloc[row] = _without_thousands(sheet, row, column, text.iloc[row], mark)
    parsed = pd.to_numeric(plain, errors="coerce")
    words = np.flatnonzero((parsed.isna() & (text != "")).to_numpy())
    for row in words.tolist():
        cell = text.iloc[row]
        if re.search(r"\d", cell) and not cell[0].isalpha() and "#" not in cell:
            raise InputError(
                f"{sheet.at(row, column)}: {shown(cell)} is not a number; correct it or leave the cell empty"
            )
    if 2 * words.size > np.count_nonzero(text != ""):
        raise InputError(
            f"{sheet.at(int(words[0]), column)}: {shown(text.iloc[words[0]])} and most cells below are no "
            f'numbers; correct them, or leave the column out with --map "{sheet.headers[column]}="'
        )
    values = np.full(len(text), np.nan)
    good = parsed.notna().to_numpy()
    values[good] = plain[good].astype(float)
    return values, words


def _without_thousands(sheet: Sheet, row: int, column: int, cell: str, mark: str) -> str:
    """A number that has another mark than the file's decimal one, as Python writes it; a word as it is.

    Raises
    ------
    InputError
        The mark may mean two numbers, or is a decimal one too.
    """
    if not NUMBER.fullmatch(cell):
        return cell
    other = "." if mark == "," else ","
    grouped = rf"[-+]?[1-9]\d{{0,2}}(?:{re.escape(other)}\d{{3}})+(?:{re.escape(mark)}\d*)?"
    if mark and re.fullmatch(grouped, cell) and (mark in cell or sheet.said):
        return cell.replace(other, "").replace(mark, ".")
    raise InputError(
        f"{sheet.at(row, column)}: {shown(cell)} may have a decimal mark or one for thousands; write all "
        "numbers alike, and say --decimal comma or --decimal point"
    )


def quantum(values: Array) -> float:
    """Step of the lattice that readings lie on, 0 where they lie on none.

    A reading that was rounded to 0.1 repeats few distinct values, all whole multiples of the smallest
    difference between two of them.
    """
    filled = values[np.isfinite(values)]
    distinct = np.unique(np.round(filled, 9))
    if distinct.size < 3 or distinct.size > 0.7 * filled.size:
        return 0.0
    steps = np.diff(distinct)
    step = float(np.median(steps))
    whole = np.abs(steps / step - np.round(steps / step)) < 0.02
    return step if whole.mean() > 0.95 and float(np.mean(np.round(steps / step) == 1)) > 0.5 else 0.0


def repeats(values: Array) -> NDArray[np.intp]:
    """Rows that repeat the reading before, where most rows do and readings lie on no lattice.

    A sensor that sticks reads so, and a logger that writes a value anew only once it has changed by enough,
    or more often than it samples.
    """
    rows = np.flatnonzero(np.isfinite(values))
    again = np.diff(values[rows]) == 0
    changes = np.count_nonzero(~again)
    if changes < _FEWEST_CHANGES or changes > again.size / 2 or quantum(values):
        return rows[:0]
    return rows[1:][again]


def between_jumps(values: Array) -> NDArray[np.intp]:
    """Rows between the jumps of a sensor that sticks; none where the sensor follows its temperature.

    Such a sensor is right when it has just jumped. Between its jumps its readings scatter about one level by
    no more than from row to row, which those of a sensor that follows do not.
    """
    rows = np.flatnonzero(np.isfinite(values))
    read = values[rows]
    steps = np.abs(np.diff(read))
    if np.count_nonzero(steps) < _FEWEST_CHANGES:
        return rows[:0]
    noise = 1.4826 * float(np.median(steps))
    jumps = steps > _LEAP * noise
    for _ in range(2):
        level = np.cumsum(np.append(0, jumps))
        count = np.bincount(level)
        mean = np.bincount(level, read) / count
        apart = np.abs(np.diff(mean))
        if apart.size < _FEWEST_CHANGES:
            return rows[:0]
        jumps[jumps] = apart > np.median(apart) / 2  # what noise made of one level are parts of it
    scatter = np.sum((read - mean[level]) ** 2) / max(read.size - count.size, 1)
    lasting = count >= _LASTING
    moved = np.ptp(mean[lasting]) > 2 * np.median(apart) if lasting.any() else False
    sticks = moved and count[lasting].sum() > 0.8 * read.size and scatter < 1.5 * noise**2 / 2
    return rows[1:][~jumps] if sticks else rows[:0]

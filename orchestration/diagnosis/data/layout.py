"""How a text file of measurements is written: separator, decimal mark, header, row of units, first row."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.headings import TIMES, is_unit, name_and_unit, plain
from warmlink.orchestration.text_files import shown

NUMBER = re.compile(r"[-+]?(?:\d[\d.,]*|[.,]\d+)(?:[eE][-+]?\d+)?")
_GROUPED = re.compile(r"[-+]?[1-9]\d{0,2}(?:[.,]\d{3})+")
_CLOCK = re.compile(r"[\d./-]*[T ]?\d{1,2}:\d{2}.*|\d{1,4}[-./]\d{1,2}[-./]\d{1,4}")

SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars", ",": "commas", " ": "spaces"}


def separator_of(name: str, lines: Sequence[str]) -> tuple[str, int]:
    """The separator by which most lines fall into single values, and the number of cells in a row.

    Raises
    ------
    InputError
        There is none.
    """
    best, chosen = 0.0, ("", 0)
    for separator in SEPARATORS:
        rows = [split(line, separator) for line in lines]
        width = most_common([len(cells) for cells in rows])
        fitting = [cells for cells in rows if len(cells) == width]
        whole = sum(sum(_is_whole(cell) for cell in cells) / width for cells in fitting) / max(len(lines), 1)
        if width > 1 and whole > best + 0.02:
            best, chosen = whole, (separator, width)
    if not chosen[1]:
        if len(lines) == 1:
            raise InputError(
                f"{name}: there are no rows below its only line {shown(lines[0])}; measure again"
            )
        raise InputError(
            f"{name}: no columns are found; separate cells by commas, semicolons, tabs or spaces, under a "
            "header row"
        )
    return chosen


def split(line: str, separator: str) -> list[str]:
    """Cells of a line; a unit in brackets stays with its name."""
    if separator == " ":
        return re.split(r"\s+(?![\[(])", line.strip())
    try:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    except csv.Error:  # a cell of 131,073 characters
        return [line]
    return [cell.strip() for cell in cells]


def _is_whole(cell: str) -> bool:
    """Whether a cell is empty, a number, a time or a word, rather than several of them in one."""
    return not cell or bool(NUMBER.fullmatch(cell) or _CLOCK.fullmatch(cell)) or cell.isalpha()


def most_common(counts: Sequence[int]) -> int:
    """The most frequent of some numbers, 0 of none."""
    return Counter(counts).most_common(1)[0][0] if counts else 0


def headers_of(
    name: str,
    rows: dict[int, list[str]],
    width: int,
    names: Sequence[str],
    commented: Sequence[list[str]] = (),
) -> tuple[list[str], list[str | None], int]:
    """Headers, units from a row of their own, and the number of the first line of cells.

    Raises
    ------
    InputError
        No row of numbers is found, or no header above it.
    """
    first = next((i for i, row in rows.items() if _is_data(row, width)), None)
    if first is None:
        raise InputError(f"{name}: no row of numbers is found under a header row; give both")
    above = [row for i, row in rows.items() if i < first and sum(map(bool, row)) > 1]
    known = {plain(each) for each in (*names, *TIMES)}
    timed = [i for i, row in enumerate(above) if any(plain(name_and_unit(c)[0]) in known for c in row)]
    as_units = bool(len(above) > 1 and all(is_unit(cell) for cell in above[-1] if cell))
    if timed:
        header = above[timed[0]]
        below = above[timed[0] + 1 :]
    elif above:
        header, below = (above[-2], above[-1:]) if as_units else (above[-1], [])
    else:
        found = [row for row in commented if abs(len(row) - width) <= 1 and len(row) > 1]
        if not found:
            raise InputError(
                f"{name}: there is no header row; head each column 'name [unit]', the first 'time [s]'"
            )
        header, below = found[-1], []
    units: list[str | None] = [None] * len(header)
    for row in below:
        if all(is_unit(cell) for cell in row if cell):
            units = [_bare(cell) or None for cell in (*row, *[""] * len(header))][: len(header)]
            break
    return [cell.strip("\"' ") for cell in header], units, first


def _bare(unit: str) -> str:
    return unit.strip().removeprefix("[").removesuffix("]").removeprefix("(").removesuffix(")").strip()


def _is_data(row: Sequence[str], width: int) -> bool:
    """Whether most cells of a row are numbers or times, or the first is one and words fill the others."""
    filled = [cell for cell in row if cell]
    said = [bool(NUMBER.fullmatch(cell) or _CLOCK.fullmatch(cell)) for cell in filled]
    if not any(said):
        return False
    return (2 * sum(said) > len(filled) and 5 * sum(said) > 2 * width) or (said[0] and len(filled) >= width)


def decimal_of(cells: Sequence[str]) -> str:
    """Decimal mark of a file by what some cells say without doubt; the marked column is judged by cell."""
    numbers = [cell for cell in cells if NUMBER.fullmatch(cell) and ("," in cell or "." in cell)]
    sure = Counter(decimal for decimal in map(_sure_decimal, numbers) if decimal)
    if sure:
        return sure.most_common(1)[0][0]
    return "point" if numbers and all("," not in cell for cell in numbers) else ""


def _sure_decimal(number: str) -> str:
    """Decimal mark of a number, `point` or `comma`; empty where its marks may be thousands as well."""
    commas, points = number.count(","), number.count(".")
    if commas and points:
        return "comma" if number.rfind(",") > number.rfind(".") else "point"
    if _GROUPED.fullmatch(number) or commas + points != 1:
        return ""
    return "comma" if commas else "point"

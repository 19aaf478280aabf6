"""How measurements are written: headers with units, separator, decimal mark, where rows begin.

A header is a name and a unit, `T (degC)`, `T_degC` or `Shaft temperature [°C]`; units may have their own row.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from warmlink.fmus.errors import InputError
from warmlink.fmus.safe_text import of_cell
from warmlink.orchestration.system.units import SPELLINGS, Conversion, parse_unit, spelled
from warmlink.orchestration.text_files import shown
from warmlink.orchestration.written.quantities import converter, heading

TIME = "time"

TIMES = (TIME, "timestamp", "time_stamp", "datetime", "date_time", "date", "elapsed", "elapsed_time", "t")
"""Names of a column of times, the first of them before the others."""

SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars", ",": "commas", " ": "spaces"}
NUMBER = re.compile(r"[-+]?(?:\d[\d.,]*|[.,]\d+)(?:[eE][-+]?\d+)?")
_GROUPED = re.compile(r"[-+]?[1-9]\d{0,2}(?:[.,]\d{3})+")
_CLOCK = re.compile(r"[\d./-]*[T ]?\d{1,2}:\d{2}.*|\d{1,4}[-./]\d{1,2}[-./]\d{1,4}")
COUNT = re.compile(rf"(?:{NUMBER.pattern})\s*(us|ms|s|sec|min|h)")
"""A time with its unit behind it."""

_VALUE = re.compile("|".join(f"(?:{form.pattern})" for form in (NUMBER, _CLOCK, COUNT)))

Headers = tuple[list[str], list[str | None]]
"""Headers of the columns, and units from a row of their own."""

SAMPLED = 200
"""Lines at the beginning, and lines from all over a file, by which one tells how it is written."""

_MOST_PARTS = 6
"""Parts, as of `rad_per_s`, that a unit at the end of a name may have."""


def plain(name: str) -> str:
    """Name as it is compared: `Shaft Temperature` is `shaft_temperature`."""
    return re.sub(r"[^\w.\[\]]+", "_", name.strip()).strip("_").lower()


def name_and_unit(header: str) -> tuple[str, str | None]:
    """Name and unit of a header; None where it has no unit, in brackets or behind `/` or `in`."""
    name, unit = heading(header)
    if unit is not None:
        return name, unit
    # Without expressions that search: a header may have many thousands of spaces or brackets.
    words = " ".join(name.split())
    *before, link, last = ["", "", *words.rsplit(" ", 2)]
    forms = [(" ".join(before), last)] if link in ("/", "in") else []
    if words.endswith(")"):
        stem, _, inner = words[:-1].partition("(")
        forms.insert(0, (stem, inner))
    for stem, written in forms:
        if stem.strip() and is_unit(written):
            return stem.strip(), written.strip()
    return name, unit


def is_unit(text: str) -> bool:
    """Whether a text is a unit, with or without brackets."""
    bare = _bare(text)
    if not bare or bare in SPELLINGS:
        return bool(bare)
    try:
        parse_unit(bare)
    except InputError:
        return False
    return not bare.isdigit()


def _bare(unit: str) -> str:
    """A unit without the brackets about it."""
    return re.sub(r"^[\[(](.*)[\])]$", r"\1", unit.strip()).strip()


def conversion_to(unit: str, si_unit: str, where: str, *, difference: bool) -> tuple[Conversion, str]:
    """Conversion of a unit as loggers spell it to an SI unit, and how we spell it; raises InputError."""
    return converter(unit, si_unit, where, difference=difference), spelled(unit, si_unit)


def with_suffix(name: str) -> Iterator[tuple[str, str]]:
    """Every way in which a name may end in a unit, as `T_degC` and `speed_rad_s` do."""
    parts = re.split(r"[_ ]", name)
    for i in range(max(1, len(parts) - _MOST_PARTS), len(parts)):
        unit = "_".join(parts[i:])
        if is_unit(unit):
            yield "_".join(parts[:i]), unit


def converts(unit: str, si_unit: str) -> bool:
    """Whether a unit measures the quantity of an SI unit."""
    try:
        conversion_to(unit, si_unit, "", difference=False)
    except InputError:
        return False
    return True


class Heading(NamedTuple):
    """A header as it is written, its name and its unit, None if nothing says it.

    Where the unit stands is the `source`: "header" or "row of units"; `below` is what such a row has.
    """

    written: str
    name: str
    unit: str | None
    source: str
    below: str | None


def headings(found: Headers) -> tuple[Heading, ...]:
    """Headers with their names and units; a unit in the header counts before one in a row of units."""
    return tuple(_heading(written, unit) for written, unit in zip(*found, strict=True))


def _heading(written: str, below: str | None) -> Heading:
    name, unit = name_and_unit(written)
    if unit is None and below is not None:
        return Heading(written, name, below, "row of units", below)
    return Heading(written, name, unit, "header", below)


class TextLayout(NamedTuple):
    """How a text is written: headers, what separates cells, decimal mark, and the first line of cells.

    A row has `width` cells, or as many as there are headers.
    """

    headers: Headers
    separator: str
    decimal: str
    first: int
    width: int


def text_layout(
    name: str,
    text: str,
    comments: Sequence[str],
    names: Sequence[str],
    separator: str = "",
    decimal: str = "",
) -> TextLayout:
    """Find how a text is written; a separator and a decimal mark that somebody says are taken.

    InputError if there are no columns, no header, or a quote that takes in rows.
    """
    head = text[:100_000].split("\n")[: 2 * SAMPLED]
    sample = [line for line in (*head[SAMPLED // 2 :], *head, *_spread(text)) if line.strip()]
    separator, width = (separator, 0) if separator else separator_of(name, sample)
    cells_of = {line: split(line, separator) for line in sample}
    width = width or most_common([len(cells_of[line]) for line in sample])
    rows = {i: cells_of[line] for i, line in enumerate(head) if line.strip()}
    commented = [split(line.lstrip("#%/ \t"), separator) for line in comments[:SAMPLED]]
    found, first = headers_of(name, rows, width, names, commented)
    mark = decimal or decimal_of([cell for line in sample for cell in cells_of[line]])
    if '"' in text:
        refuse_open_quotes(name, text, separator)
    return TextLayout(found, separator, mark, first, max(width, len(found[0])))


def _spread(text: str) -> list[str]:
    """Whole lines from all over a long text."""
    places = range(0, len(text), -(-len(text) // SAMPLED)) if len(text) > 100_000 else ()
    begins = (text.find("\n", place) + 1 for place in places)
    return [text[begin : text.find("\n", begin)] for begin in begins]


def separator_of(name: str, lines: Sequence[str]) -> tuple[str, int]:
    """The separator by which most lines fall into single values, and the number of cells in a row."""
    best, chosen, width, text = 0.0, "", 0, "\n".join(lines)
    for separator in SEPARATORS:
        if separator != " " and separator not in text:  # spaces stand for tabs as well
            continue
        rows = [split(line, separator) for line in lines]
        usual = most_common([len(cells) for cells in rows])
        if usual < 2:
            continue
        fitting = (cell for cells in rows if len(cells) == usual for cell in cells)
        # Cells that are empty, a number, a time or a word, rather than several of them in one.
        single = sum(not cell or is_value(cell) or cell.isalpha() for cell in fitting)
        whole = single / max(usual * len(lines), 1)
        if whole > best + 0.02:
            best, chosen, width = whole, separator, usual
    if width:
        return chosen, width
    if len(lines) == 1:
        raise InputError(f"{name}: there are no rows below its only line {shown(lines[0])}; measure again")
    raise InputError(
        f"{name}: no columns are found; separate cells by commas, semicolons, tabs or spaces, under a "
        "header row"
    )


def split(line: str, separator: str) -> list[str]:
    """Cells of a line; a unit in brackets stays with its name."""
    if separator == " ":
        return re.split(r"\s+(?![\[(])", line.strip())
    try:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    except csv.Error:  # a cell of 131,073 characters
        return [line]
    return [cell.strip() for cell in cells]


def refuse_open_quotes(name: str, text: str, separator: str) -> None:
    """Raise InputError where a quoted cell takes in rows.

    A note of several lines is no such cell: none of its lines begins with a value and a separator.
    """
    begins = r"(?:^|\s)" if separator == " " else rf"(?:^|{re.escape(separator)})[ ]*"
    for found in re.finditer(rf'(?m){begins}"((?:[^"]++|"")*+)("?)', text):
        _, *taken = found[1].split("\n")
        cells = (split(line, separator) for line in taken)
        if taken and (not found[2] or any(len(row) > 1 and is_value(row[0]) for row in cells)):
            line = 1 + text.count("\n", 0, found.start(1))
            rows = f"{len(taken)} lines" if len(taken) > 1 else "line"
            raise InputError(
                f'{name}: row {line}: a quote (") opens a cell that takes in the {rows} below; close it, or '
                "take it out"
            )


def is_value(cell: str) -> bool:
    """Whether a cell holds a number, a time or a date."""
    return _VALUE.fullmatch(cell) is not None


def most_common(counts: Sequence[int]) -> int:
    """The most frequent of some numbers, 0 of none."""
    return Counter(counts or [0]).most_common(1)[0][0]


def headers_of(
    name: str,
    rows: dict[int, list[str]],
    width: int,
    names: Sequence[str],
    commented: Sequence[list[str]] = (),
) -> tuple[Headers, int]:
    """Headers, units from a row of their own, and the number of the first line of cells."""
    first = next((i for i, row in rows.items() if _is_data(row, width)), None)
    if first is None:
        raise InputError(f"{name}: no row of numbers is found under a header row; give both")
    above = [row for i, row in rows.items() if i < first and sum(map(bool, row)) > 1]
    known = {plain(each) for each in (*names, *TIMES)}
    timed = [i for i, row in enumerate(above) if any(plain(name_and_unit(c)[0]) in known for c in row)]
    if timed:
        header, *below = above[timed[0] :]
    elif above:
        header, *below = above[-2:] if len(above) > 1 and _are_units(above[-1]) else above[-1:]
    else:
        found = [row for row in commented if abs(len(row) - width) <= 1 and len(row) > 1]
        if not found:
            raise InputError(
                f"{name}: there is no header row; head each column 'name [unit]', the first 'time [s]'"
            )
        header, below = found[-1], []
    written = next((row for row in below if _are_units(row)), [])
    units = [*(_bare(cell) or None for cell in written), *[None] * len(header)][: len(header)]
    return ([of_cell(cell).strip("\"' ") for cell in header], units), first


def _are_units(row: Sequence[str]) -> bool:
    return all(is_unit(cell) for cell in row if cell)


def _is_data(row: Sequence[str], width: int) -> bool:
    """Whether most cells of a row are numbers or times, or the first is one and words fill the others."""
    said = [is_value(cell) for cell in row if cell]
    most = 2 * sum(said) > len(said) and 5 * sum(said) > 2 * width
    return most or (any(said[:1]) and len(said) >= width)


def decimal_of(cells: Sequence[str]) -> str:
    """Decimal mark of a file by what some cells say without doubt; the marked column is judged by cell."""
    numbers = [cell for cell in cells if NUMBER.fullmatch(cell) and ("," in cell or "." in cell)]
    if sure := [mark for mark in map(_sure_decimal, numbers) if mark]:
        return Counter(sure).most_common(1)[0][0]
    return "point" if numbers and all("," not in cell for cell in numbers) else ""


def _sure_decimal(number: str) -> str:
    """Decimal mark of a number, `point` or `comma`; empty where its marks may be thousands as well."""
    commas, points = number.count(","), number.count(".")
    if commas and points:
        return "comma" if number.rfind(",") > number.rfind(".") else "point"
    if _GROUPED.fullmatch(number) or commas + points != 1:
        return ""
    return "comma" if commas else "point"

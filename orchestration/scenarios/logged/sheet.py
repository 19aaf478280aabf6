"""A file of measurements, or a DataFrame, as columns of cells under their headers, whatever a logger adds.

pandas reads the cells. What is found here is where they begin and how they are written: separator, decimal
mark, header, row of units, comments.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.fmus.arguments import argument, path_given
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.scenarios.logged import layout
from warmlink.orchestration.text_files import demand_file, measured_text, shown

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    from numpy.typing import NDArray

DECIMALS = {"point": ".", "comma": ","}

_COMMENTS = ("#", "%", "//")
_COMMENT_LINE = re.compile(rf"(?m)^(?:{'|'.join(_COMMENTS)})[^\r\n]*")
_EXCEL = (".xlsx", ".xlsm", ".xls", ".ods")


@dataclass(frozen=True)
class Sheet:
    """Columns of cells: column i under heading i.

    The index of the cells is the line of the file, or the row of a DataFrame from 1. The decimal mark is
    "point", "comma", or "" where no cell tells; `said`: the user said which. `form` is how it is written,
    in a few words.
    """

    name: str
    headings: Sequence[layout.Heading]
    cells: pd.DataFrame
    decimal: str
    said: bool
    form: str

    @property
    def headers(self) -> list[str]:
        """Headers as they are written."""
        return [each.written for each in self.headings]

    def at(self, row: int, column: int) -> str:
        """Where a cell stands, for a sentence."""
        return f"{self.name}: row {self.cells.index[row]}, column {self.headers[column]!r}"

    def of(self, column: int) -> str:
        """Which column it is, for a sentence."""
        return f"{self.name}: column {self.headers[column]!r}"

    def cell(self, row: int, column: int) -> str:
        """A cell as a sentence shows it."""
        return shown(str(self.cells[column].iloc[row]))

    def refuse(self, rows: NDArray[np.intp], column: int, sentence: str) -> None:
        """Raise InputError at the first of some rows, where there are any; `{}` stands for its cell."""
        for row in rows[:1].tolist():
            raise InputError(f"{self.at(row, column)}: {sentence.replace('{}', self.cell(row, column))}")

    def taken_for_missing(self, rows: NDArray[np.intp], column: int) -> str:
        """Say which cells are taken for missing values."""
        row, more = int(rows[0]), f", as are {rows.size - 1} more in this column" if rows.size > 1 else ""
        return f"{self.at(row, column)}: {self.cell(row, column)} is taken for a missing value{more}"


@dataclass(frozen=True)
class Place:
    """A column that is used: its place, what its header or the user says, and the variable that it is.

    The unit is None where nothing says it; `source` is where it stands: "header", "row of units", "name" or
    what says so. A `variable` may be "time", or "date" beside a time of the day. `chosen`: the user named it.
    """

    column: int
    name: str
    unit: str | None
    variable: str
    source: str
    chosen: bool


def read_sheet(source: Path | pd.DataFrame, decimal: str = "", names: Sequence[str] = ()) -> Sheet:
    """Read a text file, a workbook, a Parquet file or a DataFrame.

    The user may say the `decimal` mark, "point" or "comma", and give names to headers, by which the header
    row is known. InputError is raised if there is no such file, no header, or rows that do not fit under
    it.
    """
    if decimal and decimal not in DECIMALS:
        raise InputError(f"{argument('decimal', decimal)}: {instead(decimal, DECIMALS)}")
    if hasattr(source, "columns"):
        return _of_frame(source, "the DataFrame", decimal, "DataFrame")
    source = path_given("data", source)
    demand_file(source, "give the path of a file of measurements")
    suffix = source.suffix.lower()
    if suffix in (".parquet", ".pq"):
        import pandas as pd
        import pyarrow

        try:
            table = pd.read_parquet(source)
        except (OSError, ValueError, pyarrow.ArrowException) as fault:
            told = f"cannot be read as Parquet ({_last(fault)}); save it anew"
            raise InputError(f"{source.name}: {told}") from None
        return _of_frame(table, source.name, decimal, "Parquet")
    if suffix in _EXCEL:
        return _of_workbook(source, decimal, names)
    return _of_text(measured_text(source), source.name, decimal, names)


def _of_frame(frame: pd.DataFrame, name: str, decimal: str, form: str) -> Sheet:
    if frame.index.name is not None or frame.index.dtype.kind in "mM":
        frame = frame.rename_axis(index=frame.index.name or "time").reset_index()
    headers = [_flat(header) for header in frame.columns]
    cells = frame.set_axis(range(len(headers)), axis=1)
    cells.index = range(1, len(cells) + 1)
    return _of_cells(name, (headers, [None] * len(headers)), cells, decimal, form)


def _flat(header: object) -> str:
    """Header of a column; of two levels the second is its unit."""
    parts = [str(part).strip() for part in header] if isinstance(header, tuple) else [str(header)]
    has_unit = len(parts) == 2 and layout.is_unit(parts[1])
    return f"{parts[0]} [{parts[1]}]" if has_unit else " ".join(parts).strip()


def _of_workbook(path: Path, decimal: str, names: Sequence[str]) -> Sheet:
    import pandas as pd

    try:
        sheets = pd.read_excel(path, sheet_name=None, header=None, dtype=object)
    except ImportError as fault:
        raise InputError(f"{path.name}: {_last(fault)}; install that, or save the sheet as CSV") from None
    except Exception as fault:  # damaged archives and sheets raise many kinds
        raise InputError(f"{path.name}: cannot be read ({_last(fault)}); save the sheet as CSV") from None
    filled = [table for table in sheets.values() if not table.empty]
    if len(filled) != 1:
        raise InputError(f"{path.name}: has {len(filled)} sheets with cells; keep one, or save one as CSV")
    (table,) = filled
    rows = [
        ["" if pd.isna(cell) else str(cell) for cell in row] for row in table.head(layout.SAMPLED).to_numpy()
    ]
    found, first = layout.headers_of(path.name, dict(enumerate(rows)), table.shape[1], names)
    cells = table.iloc[first:].infer_objects().dropna(how="all")
    cells.index += 1
    return _of_cells(path.name, *_fitted(path.name, found, cells, ""), decimal, "workbook")


def _of_cells(name: str, found: layout.Headers, cells: pd.DataFrame, decimal: str, form: str) -> Sheet:
    """Cells that have types already; those that are text tell the decimal mark."""
    some = cells.iloc[:: max(len(cells) // layout.SAMPLED, 1)].to_numpy(dtype=object).ravel()
    mark = decimal or layout.decimal_of([cell.strip() for cell in some if isinstance(cell, str)])
    return Sheet(name, layout.headings(found), cells, mark, bool(decimal), form)


def _of_text(text: str, name: str, decimal: str, names: Sequence[str]) -> Sheet:
    comments: list[str] = []
    if text.startswith(_COMMENTS) or any(f"\n{mark}" in text for mark in _COMMENTS):
        comments = [found[0] for found in _COMMENT_LINE.finditer(text)]
        text = _COMMENT_LINE.sub("", text)  # left blank, so that rows keep their numbers
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    said = re.match(rf'"?sep=([{"".join(layout.SEPARATORS)}])"?(?=\n)', text)
    text = text[: said.start()] + text[said.end() :] if said else text
    found = layout.text_layout(name, text, comments, names, said[1] if said else "", decimal)
    separator, mark = found.separator, found.decimal
    # One column more, to see what stands beyond the headers.
    cells = _parsed(text.split("\n", found.first)[found.first], name, separator, found.width + 1, mark)
    cells.index += found.first + 1
    headers, cells = _fitted(name, found.headers, cells.dropna(how="all"), separator)
    if separator == " " and cells.iloc[:, -1].hasnans:
        short = cells.index[cells.iloc[:, -1].isna()][0]
        raise InputError(
            f"{name}: row {short} has fewer cells than there are headers, and between spaces an empty cell "
            "is not seen; write NaN in it, or separate cells by semicolons"
        )
    if separator == " ":
        cells = cells.apply(lambda each: each if each.dtype.kind in "iufb" else each.where(each != "NaN"))
    words = [f"separated by {layout.SEPARATORS.get(separator, repr(separator))}"]
    words += [f"decimal {mark}"] if mark else []
    words += [f"{len(comments)} comment line{'s' * (len(comments) > 1)}"] if comments else []
    words += ["a row of units"] if any(headers[1]) else []
    return Sheet(name, layout.headings(headers), cells, mark, bool(decimal), ", ".join(words))


def _parsed(text: str, name: str, separator: str, width: int, mark: str) -> pd.DataFrame:
    """Cells of a text without headers, under the numbers of its lines from 0."""
    import pandas as pd

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", pd.errors.ParserWarning)
            cells = pd.read_csv(
                StringIO(text),
                sep=r"\s+" if separator == " " else separator,
                header=None,
                names=range(width),
                index_col=False,
                skip_blank_lines=False,
                skipinitialspace=True,
                keep_default_na=False,  # a word is counted, not passed over
                na_values=[""],
                decimal=DECIMALS.get(mark, "."),
                low_memory=False,
            )
    except pd.errors.ParserWarning:  # pandas would cut its first row
        told = "the first row has more cells than there are headers"
        raise InputError(f"{name}: {told}; {_remedy(separator)}") from None
    except ValueError as fault:  # pandas' own faults are of this kind
        told = f"cannot be read as columns ({_last(fault)}); {_remedy(separator)}"
        raise InputError(f"{name}: {told}") from None
    return cells


def _fitted(
    name: str, found: layout.Headers, cells: pd.DataFrame, separator: str
) -> tuple[layout.Headers, pd.DataFrame]:
    """Headers and cells without empty columns at the end; raises InputError where cells have no header."""
    headers, units = found
    while headers and not headers[-1]:
        headers, units = headers[:-1], units[:-1]
    beyond = cells.iloc[:, len(headers) :].dropna(how="all")
    if not beyond.empty:
        raise InputError(
            f"{name}: row {beyond.index[0]} has more cells than there are headers ({len(headers)}); "
            f"{_remedy(separator)}"
        )
    return (headers, units), cells.iloc[:, : len(headers)].set_axis(range(len(headers)), axis=1)


def _remedy(separator: str) -> str:
    commas = "; where commas are decimal marks too, separate cells by semicolons"
    return f"give every column a header{commas if separator == ',' else ' and every row the same cells'}"


def _last(fault: Exception) -> str:
    """What a library complains of, on one line."""
    return str(fault).strip().rpartition("\n")[2].rstrip(".")

"""A run's values as files that pandas and other tools read, and drawn over time."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead, several
from warmlink.fmus.safe_text import as_cell
from warmlink.orchestration.master.recording.result import RecordTable
from warmlink.orchestration.report.figures import time_plot
from warmlink.orchestration.report.recorded import TIME, columns_of
from warmlink.orchestration.text_files import shortened
from warmlink.orchestration.written.quantities import heading

ERRORS = ("uncompensated_error", "error")
"""What is drawn where no variable is named."""


BLOCK_ROWS = 1 << 12


def plot(results: Any, *variables: str | Sequence[str], against: Any = None) -> Any:
    """Plotly figure of variables over time, all of one unit.

    Parameters
    ----------
    results, against : what `run` or `simulate` gave, a DataFrame with columns as `time [s]`, or a file or
        folder with their results; of the second the variables are drawn beside those of the first. Of what
        `compare` gave, the worst error of each controller in each duty cycle is drawn.
    variables : names, as `link.elongation`; the error of the tool point that `run` tells, by default

    Raises
    ------
    InputError
        If there are no such results or variables, or they are not of one unit.

    Examples
    --------
    >>> outcome = wl.run("stop_and_go", "lag")
    >>> wl.plot(outcome, "link.elongation").write_html("growth.html")
    """
    import pandas

    if not isinstance(results, pandas.DataFrame | str | Path):
        from warmlink.orchestration.report.comparison import Comparison, worst_errors

        if isinstance(results, Comparison):
            return worst_errors(results)
    found = columns_of(results)
    columns = {heading(name)[0]: name for name in found.names if name != TIME}
    asked = [name for each in variables for name in several(each)]
    chosen = asked or [name for name in ERRORS if name in columns]
    if not chosen:
        raise InputError(f"no variable is named, and the results hold no error; {instead('', columns)}")
    for name in chosen:
        if name not in columns:
            raise InputError(f"{name}: no such variable in the results; {instead(name, columns)}")
    units = {heading(columns[name])[1] or "1" for name in chosen}
    if len(units) != 1:
        told = ", ".join(sorted(map(shortened, units)))
        raise InputError(f"{', '.join(chosen)}: is of {told}; name variables of one unit")
    (unit,) = units
    lines = {name: found[columns[name]] for name in chosen}
    if against is not None:
        other = columns_of(against)
        for name in chosen:
            if columns[name] not in other.names:
                raise InputError(f"{name}: the results to compare with have no such variable; leave it out")
            # Beyond its end it is not known.
            there = np.interp(found.time, other.time, other[columns[name]], left=np.nan, right=np.nan)
            lines[f"{name}, the other"] = there
    factor = 1.0
    drawn = [values[np.isfinite(values)] for values in lines.values()]
    if unit == "m" and max(np.max(np.abs(values), initial=0.0) for values in drawn) < 1e-3:
        unit, factor = "µm", 1e6
    axis = chosen[0] if len(chosen) == 1 else ""  # of several, the legend tells
    scaled = {name: factor * values for name, values in lines.items()}
    return time_plot(found.time, scaled, f"{axis} [{shortened(unit)}]".strip())


def picture(figure: Any, path: Path, kind: str) -> None:
    """Draw the lines of a plot into a file of a kind: svg, png or pdf."""
    from matplotlib.figure import Figure

    styles = {"solid": "-", "dash": "--", "dot": ":"}
    drawn = Figure(figsize=(8, 4), layout="constrained")
    axes = drawn.subplots()
    for line in figure.data:
        lengths = tuple(map(float, re.findall(r"\d+(?=px)", line.line.dash)))
        style = (0, lengths) if lengths else styles.get(line.line.dash, "-.")
        axes.plot(line.x, line.y, linestyle=style, color=line.line.color, label=line.name)
    axes.set(xlabel=figure.layout.xaxis.title.text, ylabel=figure.layout.yaxis.title.text)
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    drawn.savefig(path, format=kind)


def refuse_unmatched(patterns: Sequence[str], names: Sequence[str]) -> None:
    """Raise InputError where one of some patterns, as `link.*`, matches no name that is recorded."""
    for pattern in patterns:
        if not any(_matches(name, pattern) for name in names):
            raise InputError(
                f"{argument('record', pattern)}: nothing of this name is recorded; {instead(pattern, names)}"
            )


def _matches(name: str, pattern: str) -> bool:
    """Whether a name is one of a pattern, in which brackets are those of names, as `reading[1]`."""
    return fnmatchcase(name, pattern.replace("[", "[[]"))


def series_writers(
    table: RecordTable, patterns: Sequence[str] = (), csv: bool = True
) -> dict[str, Callable[[Path], object]]:
    """What writes `results.parquet`, and `results.csv`: a column for each variable, its unit in the name.

    Written block by block, so that a run whose values lie on disk never has to fit into the memory. Of
    variables those are written that match one of `patterns`, such as `link.*`; without patterns all are.
    """
    import pyarrow
    import pyarrow.csv
    from pyarrow import parquet

    names = [name for name in table.names if any(_matches(name, p) for p in patterns)] or table.names
    headings = [TIME, *(table.heading(name) for name in names)]
    columns = [table.names.index(name) for name in names]
    kinds = [pyarrow.float64(), *(getattr(pyarrow, table.types.get(name, "float64"))() for name in names)]

    def schema(named: Sequence[str]) -> Any:
        return pyarrow.schema(zip(named, kinds, strict=True))

    def write(writer: Any, named: Sequence[str]) -> None:
        with writer:
            for block in _blocks(table, columns):
                # From buffers, since anything else would load pandas first.
                buffers = [[None, pyarrow.py_buffer(column)] for column in np.ascontiguousarray(block)]
                arrays = [
                    pyarrow.Array.from_buffers(kind, block.shape[1], each)
                    for kind, each in zip(kinds, buffers, strict=True)
                ]
                writer.write_table(pyarrow.Table.from_arrays(arrays, names=named))

    writers: dict[str, Callable[[Path], object]] = {
        "results.parquet": lambda path: write(
            parquet.ParquetWriter(path, schema(headings), use_dictionary=False), headings
        )
    }
    if csv:
        cells = [as_cell(heading) for heading in headings]
        writers["results.csv"] = lambda path: write(pyarrow.csv.CSVWriter(path, schema(cells)), cells)
    return writers


def _blocks(table: RecordTable, columns: Sequence[int]) -> Iterator[NDArray[np.float64]]:
    """Times and values of some thousand points after another, shape (1 + columns, points)."""
    times = table.times
    for first in range(0, len(table), BLOCK_ROWS):
        values = np.asarray(table.values[first : first + BLOCK_ROWS])[:, columns]
        yield np.vstack([times[first : first + BLOCK_ROWS], values.T])

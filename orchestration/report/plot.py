"""Variables of one run, or of two beside each other, over time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.fmus.names import instead
from warmlink.orchestration.report.figures import time_plot
from warmlink.orchestration.scenarios.quantity import heading

if TYPE_CHECKING:
    import pandas

TIME = "time [s]"

ERRORS = ("uncompensated_error", "error")
"""What is drawn where no variable is named."""


def plot(results: Any, *variables: str, against: Any = None) -> Any:
    """Plotly figure of variables over time, all of one unit.

    Parameters
    ----------
    results : what `run` or `simulate` gave, a DataFrame, or a file or folder with their results
    variables : names, as `link.elongation`; the error of the tool point that `run` tells, by default
    against : other results, whose variables are drawn beside them

    Raises
    ------
    InputError
        If there are no such results or variables, or they are not of one unit.
    """
    frame = frame_of(results)
    columns = {heading(str(column))[0]: str(column) for column in frame.columns if column != TIME}
    variables = variables or tuple(name for name in ERRORS if name in columns)
    if not variables:
        raise InputError(f"no variable is named, and the results hold no error; {instead('', columns)}")
    for name in variables:
        if name not in columns:
            raise InputError(f"{name}: no such variable in the results; {instead(name, columns)}")
    units = {heading(columns[name])[1] or "1" for name in variables}
    if len(units) != 1:
        told = ", ".join(sorted(units))
        raise InputError(f"{', '.join(variables)}: is of {told}; name variables of one unit")
    (unit,) = units
    lines = {name: np.asarray(frame[columns[name]]) for name in variables}
    if against is not None:
        other = frame_of(against)
        for name in variables:
            if columns[name] not in other:
                raise InputError(f"{name}: the results to compare with have no such variable; leave it out")
            lines[f"{name}, the other"] = np.interp(frame[TIME], other[TIME], other[columns[name]])
    factor = 1.0
    if unit == "m" and max(np.nanmax(np.abs(values)) for values in lines.values()) < 1e-3:
        unit, factor = "µm", 1e6
    axis = variables[0] if len(variables) == 1 else ""  # of several, the legend tells
    drawn = {name: factor * values for name, values in lines.items()}
    return time_plot(frame[TIME], drawn, f"{axis} [{unit}]".strip())


def picture(figure: Any, path: Path, kind: str) -> None:
    """Draw the lines of a plot into a file of a kind: svg, png or pdf; InputError without matplotlib."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtraError("a picture", "studies") from None

    styles = {"solid": "-", "dash": "--", "dot": ":"}
    drawn = Figure(figsize=(8, 4), layout="constrained")
    axes = drawn.subplots()
    for line in figure.data:
        style = styles.get(line.line.dash, "-.")
        axes.plot(line.x, line.y, style, color=line.line.color, label=line.name)
    axes.set(xlabel=figure.layout.xaxis.title.text, ylabel=figure.layout.yaxis.title.text)
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    drawn.savefig(path, format=kind)


def frame_of(results: Any) -> pandas.DataFrame:
    """Results of a run as columns, wherever they are; raises InputError where there are none."""
    import pandas

    if isinstance(results, pandas.DataFrame):
        return results
    if not isinstance(results, str | Path):
        found: pandas.DataFrame = results.to_frame()
        return found
    path = Path(results)
    places = [path / "results.parquet", path / "results.csv"] if path.is_dir() else [path]
    for place in places:
        if place.is_file():
            read = pandas.read_parquet if place.suffix == ".parquet" else pandas.read_csv
            try:
                table = read(place)
            except (OSError, ValueError) as fault:
                raise InputError(f"{place}: cannot be read ({str(fault).splitlines()[0]})") from None
            if TIME not in table:
                raise InputError(f"{place}: has no column {TIME!r}; give results of run or simulate")
            return table
    raise InputError(f"{path}: no results there; give a folder with results.parquet, or the file itself")

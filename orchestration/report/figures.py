"""Plots over time, alike in every report: one look, units on every axis."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, count
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warmlink.orchestration.arrays import Array


class LineLook(NamedTuple):
    """How a line is drawn: its colour on white and on dark paper, and the lengths of its dashes in pixels."""

    colour: str
    dark: str
    dashes: str

    def line(self) -> dict[str, Any]:
        """The line as plotly wants it."""
        dashes = self.dashes.replace(" ", "px,") + "px" if self.dashes else "solid"
        return {"color": self.colour, "dash": dashes, "width": 2}


LOOKS = (
    LineLook("#5b6577", "#aab3c2", ""),
    LineLook("#0072b2", "#56b4e9", "8 4"),
    LineLook("#c04f00", "#ff9c5b", "2 3"),
    LineLook("#00795a", "#3fc79a", "10 3 2 3"),
    LineLook("#a8457c", "#e79ac4", "14 4"),
    LineLook("#8a6100", "#e6b422", "14 3 2 3 2 3"),
    LineLook("#8a5fb0", "#bd9be6", "5 2 5 2 2 2"),
)
"""Looks of lines, told apart by colours and, by those who do not see them, by dashes."""

LOOK_OF = {
    **{"none": 0, "uncompensated_error": 0},
    **{"lag": 1, "observer": 2, "regression": 3, "observer_drift": 4, "analytic": 5, "linear_observer": 6},
}
"""Which of the looks the line of a controller has, on every page."""

COLOURS = (*(look.colour for look in LOOKS[1:]), LOOKS[0].colour, "#2b8fa8")
DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")
"""Dashes of lines that are no controllers', beside the colours."""

MOST_POINTS = 2000
"""Points a line keeps in a report; the files beside it hold them all."""

CELL_HIGH, NAME_HIGH = 40, 24
"""Pixels of a heat map's cells, and of the name above each row of them."""


def chart(
    *traces: dict[str, Any], x: Any = "", y: Any = "", height: int = 360, least_width: int = 10, **layout: Any
) -> Any:
    """Plotly figure of traces, as in plotly's JSON, in the common look; the layout takes further entries.

    `x` and `y` are titles of the axes, or all that is said of them.
    """
    import plotly.graph_objects as go

    for name, told in (("xaxis", x), ("yaxis", y)):
        if told:
            layout[name] = {"title": told} if isinstance(told, str) else told
    return styled(go.Figure(list(traces)), height, least_width).update_layout(layout)


def time_plot(
    seconds: ArrayLike,
    lines: Mapping[str, ArrayLike],
    axis: str,
    tolerance: float | None = None,
    height: int = 360,
) -> Any:
    """Plotly figure of lines over time in minutes or hours.

    Parameters
    ----------
    seconds : times, shape (points,)
    lines : values by the line's name, each of shape (points,)
    axis : quantity and unit of the values
    tolerance : half the height of a band about 0 in which errors in µm are wanted
    height : as of `styled`
    """
    every = np.asarray(seconds)
    kept = np.unique(np.linspace(0, every.size - 1, min(MOST_POINTS, every.size)).astype(np.int64))
    shown = every[kept].astype(np.float64)
    unit, scale = ("h", 3600.0) if shown[-1] > 3 * 3600 else ("min", 60.0)
    times, traces = _narrow(shown / scale), []
    for i, (name, values) in enumerate(lines.items()):
        x, y = times, np.asarray(values, np.float32)[kept]
        line = {"color": COLOURS[i % len(COLOURS)], "dash": DASHES[i % len(DASHES)], "width": 2}
        if not LOOK_OF.keys().isdisjoint(lines):
            line = LOOKS[looks_of([*lines])[i]].line()
        traces.append({"x": x, "y": y, "name": name, "mode": "lines", "line": line})
    x_axis, y_axis = ({"title": title, "zeroline": False} for title in (f"time [{unit}]", axis))
    figure = chart(*traces, x=x_axis, y=y_axis, height=height)
    if tolerance is not None:
        place = {"annotation_text": f"±{tolerance:g} µm", "annotation_position": "top right"}
        look = {"fillcolor": "#3d8f6f", "opacity": 0.13, "line_width": 0}
        figure.add_hrect(y0=-tolerance, y1=tolerance, **look, **place)
    return figure


def _narrow(times: Array) -> NDArray[np.floating[Any]]:
    """Times in half the room where that keeps the steps between them: of seconds since 1970 it does not."""
    narrow = times.astype(np.float32)
    return narrow if np.allclose(np.diff(narrow), np.diff(times), rtol=0.01, atol=0.0) else times


def looks_of(names: Sequence[str]) -> list[int]:
    """Which of the looks each line of a plot has, by the controller that it is of or by its own name.

    What is no shipped controller takes those that are left, in their order.
    """
    held = {LOOK_OF[name] for name in names if name in LOOK_OF}
    left: Iterator[int] = chain((i for i in range(len(LOOKS)) if i not in held), count(len(LOOKS)))
    return [(LOOK_OF[name] if name in LOOK_OF else next(left)) % len(LOOKS) for name in names]


def styled(figure: Any, height: int = 360, least_width: int = 10) -> Any:
    """Figure in the reports' common look; on a page narrower than `least_width` [pixels] it is scrolled."""
    figure.update_layout(
        template="plotly_white",
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        height=height,
        meta=least_width,
        margin={"l": 70, "r": 20, "t": 30, "b": 50},
        # Below, where it touches neither the titles nor plotly's buttons however many lines it takes.
        legend={
            "orientation": "h",
            "y": 0,
            "yref": "container",
            "yanchor": "bottom",
            "x": 0,
            "itemsizing": "constant",
        },
        font={"family": "system-ui, sans-serif", "size": 13},
    )
    return figure


def heat_map(
    columns: Sequence[str],
    rows: Sequence[str],
    values: ArrayLike,
    texts: Sequence[Sequence[str]],
    limit: float,
    unit: str,
) -> Any:
    """Plotly figure of values above 0 in cells, shape (rows, columns): blue below a limit, orange above it.

    Colours go by the ratio to the limit, from a tenth to ten times it. NaN leaves a cell blank. The name of
    a row stands above its cells, so that a telephone shows all columns.
    """
    ratio = np.log10(np.maximum(np.asarray(values, dtype=float), 1e-12) / limit)
    cells = {
        "type": "heatmap",
        "x": list(columns),
        "y": list(rows),
        "z": np.clip(ratio, -1, 1),
        "text": [list(line) for line in texts],
        "texttemplate": "%{text}",
        "textfont": {"color": "#1d2433"},
        # Told apart by the colour-blind too, and pale enough for dark figures.
        "colorscale": ((0, "#6fa8dc"), (0.5, "#f7f7f7"), (1, "#f0953f")),
        "zmin": -1,
        "zmax": 1,
        "xgap": 2,
        "ygap": NAME_HIGH,
        "colorbar": {
            "orientation": "h",
            "tickvals": [-1, 0, 1],
            "ticklabeloverflow": "allow",
            "len": 0.8,
            "ticktext": [f"{limit * factor:g} {unit}" for factor in (0.1, 1, 10)],
            "thickness": 10,
            "y": 0,
            "yref": "container",
            "yanchor": "bottom",
        },
    }
    place = {"x": 0, "xref": "paper", "xanchor": "left", "yanchor": "bottom", "showarrow": False}
    named = [{"text": name, "y": i, "yshift": CELL_HIGH / 2, **place} for i, name in enumerate(rows)]
    broken = [name.replace("_", "_<br>") for name in columns]
    return chart(
        cells,
        x={
            **{"side": "top", "tickvals": list(columns), "ticktext": broken, "tickangle": 0},
            **{"ticklabelstandoff": NAME_HIGH // 2, "showgrid": False},
        },
        y={"autorange": "reversed", "showticklabels": False, "showgrid": False},
        height=165 + (CELL_HIGH + NAME_HIGH) * len(rows),
        least_width=58 * len(columns),
        annotations=named,
        # Room above the columns' names for the figure's tools, and below the cells for the colours.
        margin={"l": 2, "r": 2, "t": 95, "b": 70},
    )

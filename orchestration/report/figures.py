"""Plots over time, alike in every report: one look, units on every axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

COLOURS = ("#3b6fb6", "#d1603d", "#3d8f6f", "#8a5fb0", "#b58a2b", "#5b6577", "#c04c7f", "#2b8fa8")
DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")
"""Lines are told apart by these too, by those who do not see the colours."""

MOST_POINTS = 2000
"""Points a line keeps in a report; the files beside it hold them all."""


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
    shown = every[kept].astype(np.float32)
    unit, scale = ("h", 3600.0) if shown[-1] > 3 * 3600 else ("min", 60.0)
    traces = []
    for i, (name, values) in enumerate(lines.items()):
        x, y = shown / scale, np.asarray(values, np.float32)[kept]
        line = {"color": COLOURS[i % len(COLOURS)], "dash": DASHES[i % len(DASHES)], "width": 2}
        traces.append({"x": x, "y": y, "name": name, "mode": "lines", "line": line})
    x_axis, y_axis = ({"title": title, "zeroline": False} for title in (f"time [{unit}]", axis))
    figure = chart(*traces, x=x_axis, y=y_axis, height=height)
    if tolerance is not None:
        place = {"annotation_text": f"±{tolerance:g} µm", "annotation_position": "top right"}
        look = {"fillcolor": "#3d8f6f", "opacity": 0.13, "line_width": 0}
        figure.add_hrect(y0=-tolerance, y1=tolerance, **look, **place)
    return figure


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
        legend={"orientation": "h", "y": 0, "yref": "container", "yanchor": "bottom", "x": 0},
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

    Colours go by the ratio to the limit, from a tenth to ten times it. NaN leaves a cell blank.
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
        "ygap": 2,
        "colorbar": {
            "tickvals": [-1, 0, 1],
            "ticktext": [f"{limit * factor:g} {unit}" for factor in (0.1, 1, 10)],
            "thickness": 12,
        },
    }
    return chart(
        cells,
        x={"side": "top", "automargin": True},
        y={"autorange": "reversed", "automargin": True},
        height=130 + 44 * len(rows),
        least_width=250 + 80 * len(columns),
        # Room above the columns' names for the figure's tools.
        margin={"t": 70, "b": 15},
    )

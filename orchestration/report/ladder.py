"""The ladder on a page: held-out errors of each way to predict, as one picture and one table."""

from __future__ import annotations

from typing import Any

from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.ladder import ladder_lines, rows_of, table_of
from warmlink.orchestration.report.figures import styled
from warmlink.orchestration.report.page import PageTable, Section

_IN_A_ROW = 4
"""Channels side by side."""

_DELIVERED, _MODEL, _PLAIN = "#3b6fb6", "#9aa3b2", "#d9c7a3"


def ladder_sections(diagnosis: Diagnosis) -> list[Section]:
    """Errors of models and of plain fits in held-out rows; nothing if no rows are held out."""
    headings, rows = table_of(diagnosis)
    if not rows:
        return []
    text = (
        "Root mean square error on rows that were held out, in the unit of each channel. The model to use "
        "from now on is starred, and blue in the picture. Models, lag and ARX simulate from the inputs "
        "alone; a ridge reads the other thermometers as well, so that it answers another question. With "
        "plain fits is the best model with a lag or ARX for each channel that these tell clearly better."
    )
    told = "\n".join((*ladder_lines(diagnosis), text))
    return [Section("How well it predicts", told, PageTable(headings, rows), _figure(diagnosis))]


def _figure(diagnosis: Diagnosis) -> Any:
    """A bar for each way to predict; a part of the figure for each channel."""
    from plotly.subplots import make_subplots

    rows = rows_of(diagnosis)
    across = min(len(rows), _IN_A_ROW)
    down = -(-len(rows) // across)
    titles = [row.channel.replace("_", " ") for row in rows]
    figure = make_subplots(
        down, across, shared_yaxes=True, subplot_titles=titles, vertical_spacing=0.3 / down
    )
    rungs = diagnosis.ladder.rungs[::-1]
    names = [rung.name for rung in rungs]
    colours = [
        _DELIVERED if rung.name == diagnosis.delivered else _MODEL if rung.is_model else _PLAIN
        for rung in rungs
    ]
    for i, row in enumerate(rows):
        at = {"row": i // across + 1, "col": i % across + 1}
        errors = [row.errors.get(name) for name in names]
        bars = {"orientation": "h", "marker": {"color": colours}, "showlegend": False}
        text = ["" if error is None else f"{error:.3g}" for error in errors]
        figure.add_bar(x=errors, y=names, text=text, **bars, **at)
        figure.update_xaxes(title_text=f"error [{row.unit}]", rangemode="tozero", **at)
    # The titles stand below plotly's buttons, which lay over the last one of the first row.
    return styled(figure, down * (34 * len(rungs) + 110) + 30).update_layout(margin_t=60)

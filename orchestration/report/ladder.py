"""On the page of a diagnosis, what is gained: the ladder of held-out errors, and the improvement by run."""

from __future__ import annotations

from typing import Any

from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.entries import errors_by_run, errors_in_noise
from warmlink.orchestration.diagnosis.answer.ladder import ladder_lines, rows_of, table_of
from warmlink.orchestration.diagnosis.ladder.judged import EQUATION
from warmlink.orchestration.report.figures import styled
from warmlink.orchestration.report.page import PageTable, Section
from warmlink.orchestration.scenarios.scenario import DEFAULT_TOLERANCE

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
        "alone; a ridge reads the other thermometers instead, so that it answers another question. With "
        "plain fits is the best model with a lag or ARX for each channel that these tell clearly better."
    )
    told = "\n".join((*ladder_lines(diagnosis), text))
    return [Section("How well it predicts", told, PageTable(headings, rows), _figure(diagnosis))]


def improvement_sections(diagnosis: Diagnosis) -> list[Section]:
    """How much better the rows of each run are predicted, and what is foreseen of other duty cycles."""
    return [Section("The improvement", _gain_text(diagnosis), _gain_table(diagnosis)), *_beyond(diagnosis)]


def _gain_text(diagnosis: Diagnosis) -> str:
    if not diagnosis.causes and diagnosis.delivered != EQUATION:
        return "No cause is added, so nothing changes."
    told = []
    for words, pair in (
        ("the model's elongation is taken out as a feed-forward", diagnosis.feed_forward),
        ("the observer designed on the model goes by the thermometers", diagnosis.observer),
    ):
        if pair is not None:
            first, then = (
                f"{1e6 * each.largest:.2f} µm ({1e6 * each.low95:.2f} to {1e6 * each.high95:.2f})"
                for each in pair
            )
            told.append(f"{first} before, {then} after, when {words}.")
    heading = "Largest error of the tool point, of two-minute means (95 %):"
    return "\n".join([heading, *told]) if told else ""


def _beyond(diagnosis: Diagnosis) -> list[Section]:
    """What the model says of other duty cycles."""
    rows = []
    for each in diagnosis.claims:
        lengths = (f"{1e6 * value:.3g}" for value in (each.largest, each.change, each.widest))
        rows.append((each.duty, *lengths, "yes" if each.holds else "no"))
    if not rows:
        why = "\n".join(f"{each}." for each in dict.fromkeys(diagnosis.unanswered.values()))
        return [Section("Other duty cycles", f"Not foreseen. {why}")] if why else []
    text = (
        "Elongation that the model to use from now on foresees. The band holds what these data leave open: "
        "the strengths, what wanders, models that fit alike, causes too weak to be seen here, and what is "
        "unexplained."
    )
    within = f"within ±{1e6 * DEFAULT_TOLERANCE:g} µm"
    headings = ("duty cycle", "largest [µm]", "changed by [µm]", "95 % band [µm]", within)
    return [Section("Other duty cycles", text, PageTable(headings, rows))]


def _gain_table(diagnosis: Diagnosis) -> PageTable:
    rows = []
    for word, heldout in (("fitted rows", False), ("held-out rows", True)):
        errors = errors_in_noise(diagnosis, diagnosis.adopted, heldout)
        if errors is not None:
            first, then = (
                f"{errors[key]:.3g} ({errors[f'{key}_95'][0]:.3g} to {errors[f'{key}_95'][1]:.3g})"
                for key in ("rmse_before", "rmse_after")
            )
            rows.append((f"{word} [sigma]", first, then))
    for run, channels in errors_by_run(diagnosis, diagnosis.adopted).items():
        rows += [
            (f"{run}: {name} [{each['unit']}]", f"{each['rmse_before']:.3g}", f"{each['rmse_after']:.3g}")
            for name, each in channels.items()
        ]
    return PageTable(("RMSE (95 % interval)", "before", "after"), rows)


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

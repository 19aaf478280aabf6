"""The pictures of a diagnosis: runs measured and simulated, strengths, and heat that is missing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.entries import in_shown_unit
from warmlink.orchestration.diagnosis.answer.profile import Profile
from warmlink.orchestration.diagnosis.answer.unknown import MissingHeat
from warmlink.orchestration.diagnosis.ladder.errors import per_si, shown
from warmlink.orchestration.diagnosis.ladder.prediction import Predicted
from warmlink.orchestration.diagnosis.terms.equation import Equation
from warmlink.orchestration.diagnosis.terms.words import equation_of, sentences
from warmlink.orchestration.report.figures import DASHES, chart, styled
from warmlink.orchestration.report.page import PageTable, Section
from warmlink.orchestration.system.units import ZERO_CELSIUS

_MOST_DRAWN = 2
"""Places whose missing heat is drawn."""

_HOURS, _DAYS = 6 * 3600.0, 4 * 86400.0
"""s that a run lasts from which on its time is told in hours, and in days."""

_MEASURED, _BEFORE, _AFTER = "#9aa3b2", "#d1603d", "#3b6fb6"


def run_sections(diagnosis: Diagnosis) -> list[Section]:
    """What was measured and simulated in each run, and what is between the two."""
    sections = []
    for run, measured in enumerate(diagnosis.experiment.runs):
        role = "held out" if measured.heldout else "fitted"
        if measured.fit_until <= diagnosis.scores.problem.data[run].time[-1]:
            length, unit = time_unit(float(measured.time[-1]))
            role += f", from {measured.fit_until / length:.3g} {unit} held out"
        text = (
            "First measured and simulated, then measured minus simulated, as a multiple of the noise (sigma)."
        )
        courses, errors = _figures(diagnosis, run)
        sections.append(Section(f"{measured.name} ({role})", text, figure=courses, beside=errors))
    return sections


def _figures(diagnosis: Diagnosis, run: int) -> tuple[Any, Any]:
    """What was measured and simulated in a run, and the errors in sigma; a row for each channel."""
    from plotly.subplots import make_subplots

    problem = diagnosis.scores.problem
    data = problem.data[run]
    channels = [i for i in range(len(problem.variables)) if np.isfinite(data.readings[:, i]).any()]
    courses, errors = (
        make_subplots(
            rows=len(channels),
            cols=1,
            shared_xaxes=True,
            vertical_spacing=0.22 / max(len(channels), 3),
            column_titles=[title],
        )
        for title in ("measured, simulated", "error / sigma")
    )
    length, unit_of_time = time_unit(float(data.time[-1]))
    pairs = [("as it stands", diagnosis.before, _BEFORE)]
    if (better := _better(diagnosis)) is not None:
        pairs.append((*better, _AFTER))

    def draw(figure: Any, row: int, word: str, values: Array, **style: Any) -> None:
        """Draw a signal in a row; the legend names those of the first."""
        x, y = (data.time / length).astype(np.float32), values.astype(np.float32)
        told = {"name": word, "legendgroup": word, "showlegend": row == 1}
        figure.add_scatter(x=x, y=y, row=row, col=1, **told, **style)

    for row, i in enumerate(channels, start=1):
        name = problem.names[problem.variables[i]]
        unit = shown(diagnosis.units()[name])
        factor, zero = per_si(unit), ZERO_CELSIUS if unit == "K" else 0.0
        measured = data.readings[:, i]
        draw(courses, row, "measured", (measured - zero) * factor, **_dots(_MEASURED))
        for (word, predicted, colour), dash in zip(pairs, DASHES, strict=False):
            readings = predicted.readings[run][:, i]
            line = {"color": colour, "width": 2, "dash": dash}
            draw(courses, row, word, (readings - zero) * factor, mode="lines", line=line)
            error = (measured - readings) / diagnosis.scores.scales[run][:, i]
            draw(errors, row, word, error, **_dots(colour))
        label = "degC" if unit == "K" else diagnosis.units()[name]
        told = f"{name.replace('_', ' ')}<br>"
        courses.update_yaxes(title_text=f"{told}[{label}]", row=row)
        errors.update_yaxes(title_text=f"{told}error / sigma [1]", row=row)
    until = diagnosis.experiment.runs[run].fit_until
    for figure in (courses, errors):
        figure.update_xaxes(title_text=f"time [{unit_of_time}]", row=len(channels))
        if until < data.time[-1]:
            grey = {"fillcolor": "#5b6577", "opacity": 0.08, "line_width": 0}
            figure.add_vrect(x0=until / length, x1=float(data.time[-1]) / length, **grey)
        styled(figure, 170 * len(channels) + 90).update_layout(margin_t=60)
    return courses, errors


def _better(diagnosis: Diagnosis) -> tuple[str, Predicted] | None:
    """What is drawn beside the model as it stands: what is delivered, else what explains most."""
    used, after = diagnosis.adopted, diagnosis.after
    if diagnosis.delivers and not any(_alike(used, each) for each in (diagnosis.before, after)):
        return "to use from now on", used
    if after is diagnosis.before:
        return None
    return "nearest causes" if diagnosis.verdict == "unknown" else "extended", after


def _alike(one: Predicted, other: Predicted) -> bool:
    pairs = zip(one.readings, other.readings, strict=True)
    return all(np.array_equal(a, b, equal_nan=True) for a, b in pairs)


def time_unit(duration: float) -> tuple[float, str]:
    """Length in s of the unit in which people tell the time of a run that lasts so many s, and its name."""
    if duration > _DAYS:
        return 86400.0, "d"
    return (3600.0, "h") if duration > _HOURS else (60.0, "min")


def _dots(colour: str) -> dict[str, Any]:
    return {"mode": "markers", "marker": {"size": 3, "color": colour}}


def profile_figure(diagnosis: Diagnosis, profiles: Sequence[Profile]) -> Any:
    """Chi-square over each strength, all else refitted: how well the data know it."""
    from plotly.subplots import make_subplots

    figure = make_subplots(rows=1, cols=len(profiles), shared_yaxes=True)
    look = {"mode": "lines+markers", "line": {"color": _AFTER, "width": 2}, "showlegend": False}
    for column, each in enumerate(profiles, start=1):
        factor, unit = in_shown_unit(diagnosis, each.item, each.variable)
        figure.add_scatter(x=factor * each.values, y=each.rise, row=1, col=column, **look)
        figure.update_xaxes(title_text=f"{each.variable}<br>[{unit}]", row=1, col=column)
    figure.add_hline(y=3.84, line={"dash": "dot", "width": 1, "color": _BEFORE}, annotation_text="95 %")
    figure.update_yaxes(title_text="rise of chi-square [1]", row=1, col=1)
    return styled(figure, 300)


def heat_figure(time: Array, heat: Array, deviation: Array) -> Any:
    """Missing heat in W over time in s, with its 95 % band."""
    length, unit = time_unit(float(time[-1]))
    at, spread, hidden = time / length, 1.96 * deviation, {"showlegend": False}
    return chart(
        {"x": at, "y": heat - spread, "line": {"width": 0}, **hidden},
        {"x": at, "y": heat + spread, "fill": "tonexty", "line": {"width": 0}, **hidden},
        {"x": at, "y": heat, "line": {"color": _AFTER}, **hidden},
        x=f"time [{unit}]",
        y="missing heat [W]",
        height=320,
    )


def heat_sections(courses: Sequence[MissingHeat]) -> list[Section]:
    """Draw the missing heat of each run."""
    sections = []
    for each in courses:
        figure = heat_figure(each.time, each.heat, each.deviation)
        text = f"To make up for all that is wrong, {each.sentence}"
        sections.append(Section(f"When heat is missing: {each.run}", text, figure=figure))
    return sections


def equation_sections(equation: Equation) -> list[Section]:
    """The equation or the set, and the missing heat with its 95 % band."""
    found = equation.discovery
    rows = [(equation_of(each.model), f"{each.score:.1f}", f"{each.chance:.2g}") for each in found.members]
    if not rows and found.tried is not None:
        best = found.tried
        rows = [(equation_of(best.model), f"{best.score:.1f}", f"{best.chance:.2g}")]
    text = sentences(equation)[0]
    text += (
        f"\n{found.thought_of} forms at places where heat may enter were thought of. The score is chi-square "
        "plus the description of the terms and their numbers; a chance near 0 is a model that leaves more "
        "than noise."
    )
    if found.thought_of and found.bare_score == found.bare_score:
        text += f" Without a term the score is {found.bare_score:.1f}."
    table = PageTable(("equation", "score", "chance"), rows) if rows else None
    sections = [Section("An equation for the missing heat", text, table)]
    for each in found.missing[:_MOST_DRAWN]:
        figure = heat_figure(each.time, each.heat, each.deviation)
        heading = f"Missing heat at the {each.place}: {each.run}"
        sections.append(Section(heading, f"{each.sentence}.", figure=figure))
    return sections

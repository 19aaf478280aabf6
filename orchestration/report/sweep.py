"""The report of a sweep: the objective over each parameter, and over all at once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from warmlink.orchestration.report.figures import styled
from warmlink.orchestration.report.page import Section, Table, versions, write_page
from warmlink.orchestration.report.study import about, parallel_coordinates
from warmlink.orchestration.studies.axis import Axis
from warmlink.orchestration.studies.points import Evaluation
from warmlink.orchestration.studies.study import Study

MOST_LINES = 5000
"""Points that the parallel coordinates show; the table holds them all."""


def write_report(study: Study, found: list[Evaluation], path: Path) -> None:
    """Write `report.html`."""
    complete = [evaluation for evaluation in found if evaluation.reason is None]
    sections = []
    if complete:
        values = [(evaluation.point, evaluation.objective) for evaluation in complete[:MOST_LINES]]
        sections.append(Section("Parallel coordinates", figure=parallel_coordinates(study, values)))
        for axis in study.axes:
            sections.append(Section(axis.name, figure=_over(study, axis, complete)))
    poisoned = [(str(i), found[i].reason or "") for i in range(len(found)) if found[i].reason is not None]
    if poisoned:
        sections.append(
            Section("Points without an objective", table=Table(("point", "because"), poisoned[:100]))
        )
    sections += [Section("Study", table=about(study)), Section("Versions", table=versions())]
    lead = "No point gave an objective."
    if complete:
        objectives = [evaluation.objective for evaluation in complete]
        lead = (
            f"{study.objective.title} from {min(objectives):.4g} to {max(objectives):.4g} "
            f"over {len(complete)} points."
        )
    write_page(path, study.title, lead, sections)


def _over(study: Study, axis: Axis, complete: list[Evaluation]) -> Any:
    import plotly.graph_objects as go

    figure = go.Figure()
    for feasible, colour, name in ((True, "#3b6fb6", "point"), (False, "#c2472b", "breaks a constraint")):
        shown = [evaluation for evaluation in complete if evaluation.feasible == feasible]
        if shown:
            figure.add_scattergl(
                x=[evaluation.point[axis.name] for evaluation in shown],
                y=[evaluation.objective for evaluation in shown],
                mode="markers",
                marker={"color": colour, "size": 6, "opacity": 0.7},
                name=name,
            )
    # Plotly's own prefixes would make "2µ [m/W]" of it.
    figure.update_xaxes(
        title=axis.heading, type="log" if axis.log else "linear", exponentformat="power", showexponent="all"
    )
    figure.update_yaxes(title=study.objective.title)
    return styled(figure, 300)

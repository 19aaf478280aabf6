"""The report of a sweep: the objective over each parameter, and over all at once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from warmlink.orchestration.report.figures import styled
from warmlink.orchestration.report.page import Section, write_page
from warmlink.orchestration.report.study import add_points, closing, label, parallel_coordinates
from warmlink.orchestration.studies.axis import Axis
from warmlink.orchestration.studies.points import Judged
from warmlink.orchestration.studies.study import Study

MOST_LINES = 5000
"""Points that the parallel coordinates show; the table holds them all."""


def write_report(study: Study, found: list[Judged], path: Path) -> None:
    """Write `report.html`."""
    complete = [evaluation for evaluation in found if evaluation.reason is None]
    sections = []
    lead = "No point gave an objective."
    if complete:
        sections.append(
            Section("Parallel coordinates", figure=parallel_coordinates(study, complete[:MOST_LINES]))
        )
        sections += [Section(axis.name, figure=_over(study, axis, complete)) for axis in study.axes]
        objectives = [evaluation.objective for evaluation in complete]
        lead = (
            f"{study.objective.title} from {min(objectives):.4g} to {max(objectives):.4g} "
            f"over {len(complete)} points."
        )
    write_page(path, study.title, lead, [*sections, *closing(study, found, "point")])


def _over(study: Study, axis: Axis, complete: list[Judged]) -> Any:
    import plotly.graph_objects as go

    figure = go.Figure()
    factor = axis.readable[1]
    add_points(figure, [factor * evaluation.point[axis.name] for evaluation in complete], complete, "point")
    figure.update_xaxes(title=label(axis))
    if axis.log:
        ticks = [float(f"{factor * level:.2g}") for level in axis.levels(5)]
        figure.update_xaxes(type="log", tickvals=ticks, ticktext=[f"{tick:g}" for tick in ticks])
    figure.update_yaxes(title=study.objective.title)
    return styled(figure, 300)

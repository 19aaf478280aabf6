"""What the reports of tuning and sweeping share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from warmlink.orchestration.report.figures import styled
from warmlink.orchestration.report.page import Table
from warmlink.orchestration.studies.study import Point, Study


def parallel_coordinates(study: Study, values: Sequence[tuple[Point, float]]) -> Any:
    """Plotly figure with an axis for each parameter and one for the objective, a line for each point."""
    import plotly.graph_objects as go

    objectives = [objective for _, objective in values]
    dimensions = [_dimension(axis.heading, [point[axis.name] for point, _ in values]) for axis in study.axes]
    dimensions.append(_dimension(study.objective.title, objectives))
    figure = go.Figure(
        go.Parcoords(
            dimensions=dimensions,
            line={"color": objectives, "colorscale": "Viridis", "showscale": True},
            labelside="bottom",
        )
    )
    styled(figure, 420)
    figure.update_layout(margin={"l": 90, "r": 40, "t": 40, "b": 60})
    return figure


def _dimension(label: str, values: Sequence[float]) -> dict[str, Any]:
    """One axis, numbered without the prefixes that plotly would put before the unit, as in `2µ [m/W]`."""
    small = max(map(abs, values)) < 1e-3
    return {"label": label, "values": list(values), "tickformat": "~e" if small else "~g"}


def about(study: Study) -> Table:
    """What was asked for."""
    rows = [
        ("controller", study.controller.name),
        ("duty cycles", ", ".join(scenario.name for scenario in study.scenarios)),
        ("mismatches", ", ".join(mismatch.name for mismatch in study.mismatches)),
        ("objective", study.objective.title),
        *((f"{c.title}", f"at most {c.at_most:g}") for c in study.constraints),
        *((axis.name, _range(axis)) for axis in study.axes),
        ("seed", str(study.seed)),
    ]
    return Table(("", "as the study file says"), rows)


def _range(axis: Any) -> str:
    if axis.choice:
        return f"one of {', '.join(f'{value:g}' for value in axis.choice)} {axis.unit}"
    return f"{axis.low:g} to {axis.high:g} {axis.unit}{', by its logarithm' if axis.log else ''}"

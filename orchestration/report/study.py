"""What the reports of tuning and sweeping share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from warmlink.orchestration.report.figures import COLOURS, styled
from warmlink.orchestration.report.page import Section, Table, versions
from warmlink.orchestration.studies.axis import Axis
from warmlink.orchestration.studies.points import Judged
from warmlink.orchestration.studies.study import Study


def parallel_coordinates(study: Study, found: Sequence[Judged]) -> Any:
    """Plotly figure with an axis for each parameter and one for the objective, a line for each point."""
    import plotly.graph_objects as go

    objectives = [each.objective for each in found]
    dimensions = []
    for axis in study.axes:
        values = [axis.readable[1] * each.point[axis.name] for each in found]
        dimensions.append({"label": label(axis), "values": values, "tickformat": "~g"})
    dimensions.append({"label": study.objective.title, "values": objectives, "tickformat": "~g"})
    line = {"color": objectives, "colorscale": "Viridis", "showscale": True}
    figure = go.Figure(go.Parcoords(dimensions=dimensions, line=line, labelside="bottom"))
    styled(figure, 420, 160 * len(dimensions))
    return figure.update_layout(margin={"l": 70, "r": 60, "t": 60, "b": 60})


def label(axis: Axis) -> str:
    """A parameter without its instance, with the unit in which it is shown."""
    return f"{axis.name.rpartition('.')[2]} [{axis.readable[0]}]"


def add_points(figure: Any, places: Sequence[float], found: Sequence[Judged], word: str) -> None:
    """Mark the objective at each place, in another shape where a constraint is broken."""
    for feasible, colour, symbol, name in (
        (True, COLOURS[0], "circle", word),
        (False, COLOURS[1], "x", "breaks a constraint"),
    ):
        shown = [i for i, each in enumerate(found) if each.reason is None and each.feasible == feasible]
        if shown:
            figure.add_scatter(
                x=[places[i] for i in shown],
                y=[found[i].objective for i in shown],
                mode="markers",
                marker={"color": colour, "symbol": symbol, "size": 7, "opacity": 0.7},
                name=name,
            )


def closing(study: Study, found: Sequence[Judged], word: str) -> list[Section]:
    """The last sections of a page: points that gave no objective, what was asked for, versions."""
    poisoned = [(str(i), each.reason) for i, each in enumerate(found) if each.reason is not None]
    sections = [Section("Study", table=_about(study)), Section("Versions", table=versions())]
    if poisoned:
        table = Table((word, "because"), poisoned[:100])
        sections.insert(0, Section(f"{word.capitalize()}s without an objective", table=table))
    return sections


def _about(study: Study) -> Table:
    rows = [
        ("controller", study.controller.name),
        ("duty cycles", ", ".join(scenario.name for scenario in study.scenarios)),
        ("mismatches", ", ".join(mismatch.name for mismatch in study.mismatches)),
        *(("objective", each.title) for each in (study.objective, study.second) if each is not None),
        *((f"{c.title}", f"at most {c.at_most:g}") for c in study.constraints),
        *((axis.name, _range(axis)) for axis in study.axes),
        ("seed", str(study.seed)),
    ]
    return Table(("", "as the study file says"), rows)


def _range(axis: Axis) -> str:
    if axis.choice:
        return f"one of {', '.join(map(axis.shown, axis.choice))}"
    return f"{axis.shown(axis.low, axis.high)}{', by its logarithm' if axis.log else ''}"

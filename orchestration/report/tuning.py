"""The report of a tuning study: how it went, what mattered, the winner."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from warmlink.orchestration.report.figures import COLOURS, styled
from warmlink.orchestration.report.page import Section, Table, write_page
from warmlink.orchestration.report.study import add_points, closing, parallel_coordinates
from warmlink.orchestration.studies.points import Judged, best
from warmlink.orchestration.studies.storage import Storage
from warmlink.orchestration.studies.study import Study

_HISTORY = "Each trial's objective, and the best of those that keep every constraint so far."
_IMPORTANCE = (
    "Share of the objective's variation that each parameter explains among the better trials (PED-ANOVA)."
)
_COORDINATES = "Each line is a trial; drag along an axis to pick some."


def write_report(study: Study, storage: Storage, trials: list[Judged], path: Path) -> None:
    """Write `report.html`."""
    complete = [trial for trial in trials if trial.reason is None]
    sections = [Section("Trials", _HISTORY, figure=_history(study, trials))]
    winner = best(trials)
    if winner is not None:
        sections.insert(0, Section("Winner", table=_winner(study, winner)))
    importance = _importance(storage) if len(complete) > 1 and len(study.axes) > 1 else None
    if importance is not None:
        sections.append(Section("What matters", _IMPORTANCE, figure=importance))
    if complete:
        sections.append(
            Section("Parallel coordinates", _COORDINATES, figure=parallel_coordinates(study, complete))
        )
    sections += closing(study, trials, "trial")
    write_page(path, study.title, _lead(study, trials, winner), sections)


def _lead(study: Study, trials: list[Judged], winner: Judged | None) -> str:
    if winner is None:
        return f"None of {len(trials)} trials keeps every constraint."
    first = trials[0]
    text = f"{study.objective.title}: {winner.objective:.4g} in trial {winner.number} of {len(trials)}"
    if study.shipped and first.reason is None:
        text += f"; as shipped {first.objective:.4g}"
    return f"{text}."


def _winner(study: Study, winner: Judged) -> Table:
    rows = [(axis.name, axis.shown(winner.point[axis.name]), axis.shown(axis.shipped)) for axis in study.axes]
    return Table(("parameter", "winner", "as shipped"), rows)


def _history(study: Study, trials: list[Judged]) -> Any:
    import plotly.graph_objects as go

    figure = go.Figure()
    add_points(figure, [trial.number for trial in trials], trials, "trial")
    leaders = [(trial.number, best(trials[: trial.number + 1])) for trial in trials]
    steps = [(number, leader.objective) for number, leader in leaders if leader is not None]
    figure.add_scatter(
        x=[number for number, _ in steps],
        y=[objective for _, objective in steps],
        mode="lines",
        line={"color": COLOURS[2], "shape": "hv", "width": 2},
        name="best so far",
    )
    figure.update_xaxes(title="trial")
    figure.update_yaxes(title=study.objective.title)
    return styled(figure)


def _importance(storage: Storage) -> Any:
    """Importance of each parameter; None where the trials do not tell."""
    import optuna

    evaluator = optuna.importance.PedAnovaImportanceEvaluator()
    try:
        figure = optuna.visualization.plot_param_importances(storage.study, evaluator=evaluator)
    except (RuntimeError, ValueError):
        return None
    figure.update_layout(title=None)
    figure.update_traces(marker_color=COLOURS[0])
    figure.update_xaxes(title="share")
    figure.update_yaxes(title=None, automargin=True)
    return styled(figure, 260)

"""The report of a tuning study: how it went, what mattered, the winner."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

from warmlink.orchestration.report.figures import COLOURS, styled
from warmlink.orchestration.report.page import Section, Table, write_page
from warmlink.orchestration.report.study import add_points, closing, parallel_coordinates
from warmlink.orchestration.studies.points import Judged, best, front
from warmlink.orchestration.studies.storage import Storage
from warmlink.orchestration.studies.study import Study
from warmlink.orchestration.studies.tune import Tuned

_HISTORY = "Each trial's objective, and the best of those that keep every constraint so far."
_IMPORTANCE = (
    "Share of the objective's variation that each parameter explains among the better trials (PED-ANOVA)."
)
_FRONT = (
    "The trials that no other one betters in both objectives; the winner is closest to the least of both."
)
_COORDINATES = "Each line is a trial; drag along an axis to pick some."


def write_report(tuned: Tuned, path: Path) -> None:
    """Write `report.html`."""
    study, trials, winner = tuned.study, tuned.trials, tuned.best
    complete = [trial for trial in trials if trial.reason is None]
    sections = [Section("Trials", _HISTORY, figure=_history(study, trials))]
    if study.second is not None and complete:
        sections.insert(0, Section("Front", _FRONT, _front_table(study, trials), _front(study, trials)))
    if winner is not None:
        sections.insert(0, Section("Winner", f"{tuned.gain.capitalize()}.", _winner(study, winner)))
    importance = _importance(tuned.storage) if len(complete) > 1 and len(study.axes) > 1 else None
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
    text = f"{study.objective.title}: {winner.objective:.4g} from trial {winner.number} of {len(trials)}"
    if study.shipped and first.reason is None:
        text += f"; as shipped {first.objective:.4g}"
    return f"{text}."


def _winner(study: Study, winner: Judged) -> Table:
    rows = [(axis.name, axis.shown(winner.point[axis.name]), axis.shown(axis.shipped)) for axis in study.axes]
    return Table(("parameter", "winner", "as shipped"), rows)


def _front_table(study: Study, trials: list[Judged]) -> Table:
    assert study.second is not None
    headings = ("trial", study.objective.title, study.second.title, *(axis.name for axis in study.axes))
    rows = [
        (
            *(str(each.number), f"{each.objective:.4g}", f"{each.second:.4g}"),
            *(axis.shown(each.point[axis.name]) for axis in study.axes),
        )
        for each in front(trials)
    ]
    return Table(headings, rows)


def _front(study: Study, trials: list[Judged]) -> Any:
    import plotly.graph_objects as go

    assert study.second is not None
    figure, kept = go.Figure(), front(trials)
    add_points(figure, [trial.second or 0.0 for trial in trials], trials, "trial")
    figure.add_scatter(
        x=[each.second for each in kept],
        y=[each.objective for each in kept],
        mode="lines",
        line={"color": COLOURS[2], "shape": "vh", "width": 2},
        name="front",
    )
    figure.update_xaxes(title=study.second.title)
    figure.update_yaxes(title=study.objective.title)
    return styled(figure)


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
    # Optuna wants to be told which of two objectives, and warns that it is to be small, as it is.
    target = None if len(storage.study.directions) == 1 else lambda trial: trial.values[0]
    warnings.filterwarnings("ignore", message="PedAnovaImportanceEvaluator computes")
    try:
        figure = optuna.visualization.plot_param_importances(
            storage.study, evaluator=evaluator, target=target, target_name="objective"
        )
    except (RuntimeError, ValueError):
        return None
    figure.update_layout(title=None)
    figure.update_traces(marker_color=COLOURS[0])
    figure.update_xaxes(title="share")
    figure.update_yaxes(title=None, automargin=True)
    return styled(figure, 260)

"""Reports of tuning, with the winner, the trials and what mattered in them, and of sweeps."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from itertools import accumulate
from pathlib import Path
from typing import Any

from warmlink.orchestration.report.figures import COLOURS, chart
from warmlink.orchestration.report.page import PageTable, Section, write_page
from warmlink.orchestration.studies.axis import Axis
from warmlink.orchestration.studies.case import Gathered
from warmlink.orchestration.studies.points import Judged, front
from warmlink.orchestration.studies.storage import Storage
from warmlink.orchestration.studies.study import Study
from warmlink.orchestration.studies.tune import Tuned

MOST_LINES = 5000
"""Points that the parallel coordinates of a sweep show; the table beside the page holds them all."""

MOST_FAILED = 100
"""Points without an objective that a page lists."""


def write_tuning(tuned: Tuned, path: Path) -> None:
    """Write `report.html` of a tuning study."""
    study, trials, winner = tuned.study, tuned.trials, tuned.best
    complete = [trial for trial in trials if trial.reason is None]
    sections = []
    if winner is not None:
        point = winner.point
        rows = [
            (axis.name, axis.shown(point[axis.name]), axis.shown(*dict.fromkeys(axis.shipped)))
            for axis in study.axes
        ]
        table = PageTable(("parameter", "winner", "as shipped"), rows)
        sections.append(Section("Winner", f"{tuned.gain[:1].upper()}{tuned.gain[1:]}.", table))
    if len(study.objectives) > 1 and complete:
        sections.append(_front(study, trials, "trial"))
    sections.append(_history(study, trials, tuned.polished))
    importance = _importance_chart(tuned.storage) if len(complete) > 1 and len(study.axes) > 1 else None
    if importance is not None:
        text = "How much each parameter decides whether a trial is among the best tenth by "
        text += f"{study.objective.title}, as shares of 1 (Optuna's PED-ANOVA); constraints do not count."
        sections.append(Section("What matters", text, figure=importance))
    if complete:
        text = "Each line is a trial; drag along an axis to pick some."
        sections.append(_parallel_coordinates(study, complete, text))
    lead = f"{len(trials)} trials: {'; '.join(tuned.reached)}."
    write_page(path, study.title, lead, [*sections, *_closing(study, trials, "trial")])


def write_sweep(study: Study, found: Sequence[Judged], path: Path) -> None:
    """Write `report.html` of a sweep."""
    complete = [evaluation for evaluation in found if evaluation.reason is None]
    sections = []
    lead = "No point gave an objective."
    if complete:
        sections = [_front(study, found, "point")] if len(study.objectives) > 1 else []
        text = f"The first {MOST_LINES} of {len(complete)} points; the table beside this page holds them all."
        text = text if len(complete) > MOST_LINES else ""
        sections.append(_parallel_coordinates(study, complete[:MOST_LINES], text))
        sections += [Section(axis.name, figure=_over(study, axis, complete)) for axis in study.axes]
        objectives = [evaluation.objective for evaluation in complete]
        span = f"from {min(objectives):.4g} to {max(objectives):.4g} over {len(complete)} points"
        lead = f"{study.objective.title} {span}."
    write_page(path, study.title, lead, [*sections, *_closing(study, found, "point")])


def _parallel_coordinates(study: Study, found: Sequence[Judged], text: str = "") -> Section:
    """Section with an axis for each parameter and each objective, a line for each point."""
    objectives, titles = (
        [each.objective for each in found],
        [_objective_label(each) for each in study.objectives],
    )
    values = [
        *(
            (_parameter_label(axis), [axis.readable[1] * each.point[axis.name] for each in found])
            for axis in study.axes
        ),
        *((title, [each.objectives[i] for each in found]) for i, title in enumerate(titles)),
    ]
    lines = {
        "type": "parcoords",
        "dimensions": [{"label": of, "values": each, "tickformat": "~g"} for of, each in values],
        "line": {"color": objectives, "colorscale": "Viridis", "showscale": True},
        "labelside": "bottom",
    }
    margin = {"l": 70, "r": 60, "t": 60, "b": 60}
    figure = chart(lines, height=420, least_width=160 * len(values), margin=margin)
    return Section("Parallel coordinates", text, figure=figure)


UNITS = {"um_s": "µm/s", "um_h": "µm/h", "um": "µm", "s": "s", "min": "min", "percent": "%"}
"""Units by the ends of the metrics' names."""


def _objective_label(objective: Gathered) -> str:
    """Title of an objective with the unit of its metric."""
    unit = next(unit for end, unit in UNITS.items() if objective.metric.endswith(f"_{end}"))
    return f"{objective.title} [{unit}]"


def _parameter_label(axis: Axis) -> str:
    """Name of a parameter without its instance, with the unit in which it is shown."""
    return f"{axis.name.rpartition('.')[2]} [{axis.readable[0]}]"


def _points(places: Sequence[float], found: Sequence[Judged], word: str) -> list[dict[str, Any]]:
    """Marks of the objective at each place, in another shape where a constraint is broken."""
    looks = {True: (COLOURS[0], "circle", word), False: (COLOURS[1], "x", "breaks a constraint")}
    marks = []
    for feasible, (colour, symbol, name) in looks.items():
        judged = zip(places, found, strict=True)
        shown = [(x, e.objective) for x, e in judged if e.reason is None and e.feasible == feasible]
        if shown:
            x, y = zip(*shown, strict=True)
            marker = {"color": colour, "symbol": symbol, "size": 7, "opacity": 0.7}
            marks.append({"x": x, "y": y, "mode": "markers", "marker": marker, "name": name})
    return marks


def _line(x: Sequence[float], y: Sequence[float], shape: str, name: str) -> dict[str, Any]:
    line = {"color": COLOURS[2], "shape": shape, "width": 2}
    return {"x": x, "y": y, "mode": "lines", "line": line, "name": name}


def _over(study: Study, axis: Axis, complete: Sequence[Judged]) -> Any:
    factor = axis.readable[1]
    x: dict[str, Any] = {"title": _parameter_label(axis)}
    if axis.log:
        ticks = [float(f"{factor * level:.2g}") for level in axis.levels(5)]
        x |= {"type": "log", "tickvals": ticks, "ticktext": [f"{tick:g}" for tick in ticks]}
    marks = _points([factor * each.point[axis.name] for each in complete], complete, "point")
    return chart(*marks, x=x, y=_objective_label(study.objective), height=300)


def _front(study: Study, found: Sequence[Judged], word: str) -> Section:
    kept, (first, second) = front(found), [_objective_label(each) for each in study.objectives]
    rows = []
    for each in kept:
        point = [axis.shown(each.point[axis.name]) for axis in study.axes]
        rows.append((str(each.number), *(f"{value:.4g}" for value in each.objectives), *point))
    marks = _points([each.objectives[-1] if each.objectives else 0.0 for each in found], found, word)
    edge = _line([each.objectives[-1] for each in kept], [each.objective for each in kept], "vh", "front")
    table = PageTable((word, first, second, *(axis.name for axis in study.axes)), rows)
    text = (
        f"The {word}s that no other one betters in both objectives; the best is closest to the least of both."
    )
    return Section("Front", text, table, chart(*marks, edge, x=second, y=first))


def _history(study: Study, trials: list[Judged], polished: Judged | None) -> Section:
    reached = accumulate((each.objective if each.feasible else math.inf for each in trials), min)
    steps = [(e.number, least) for e, least in zip(trials, reached, strict=True) if least < math.inf]
    star = {"color": COLOURS[3], "symbol": "star", "size": 14}
    look: dict[str, Any] = {"mode": "markers", "marker": star, "name": "winner, polished"}
    winner = [] if polished is None else [{"x": [polished.number], "y": [polished.objective], **look}]
    figure = chart(
        *_points([trial.number for trial in trials], trials, "trial"),
        *winner,
        _line([number for number, _ in steps], [least for _, least in steps], "hv", "best so far"),
        x="number of the trial [1]",
        y=_objective_label(study.objective),
    )
    text = "Each trial's objective, and the least of those that keep every constraint so far."
    return Section("Trials", text, figure=figure)


def _importance_chart(storage: Storage) -> Any:
    """Bars of the importance of each parameter; None if the trials do not tell it."""
    import optuna

    # Of two objectives Optuna is told which, and warns that it takes the least for the best, as it should.
    target = None if len(storage.study.directions) == 1 else lambda trial: trial.values[0]
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="PedAnovaImportanceEvaluator computes")
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)  # Optuna 4 says so of it
        evaluator = optuna.importance.PedAnovaImportanceEvaluator()
        try:
            found = optuna.importance.get_param_importances(storage.study, evaluator=evaluator, target=target)
        except (RuntimeError, ValueError):
            return None
    names, shares = list(found), list(found.values())
    told = {"text": [f"{share:.2f}" for share in shares], "textposition": "outside", "cliponaxis": False}
    look = {"type": "bar", "orientation": "h", "marker": {"color": COLOURS[0]}, **told}
    down = {"autorange": "reversed", "automargin": True}
    # Room for the figures that stand beyond the bars.
    across = {"title": "share [1]", "range": [0, 1.2], "tickvals": [0, 0.5, 1]}
    return chart({"x": shares, "y": names, **look}, x=across, y=down, height=260)


def _closing(study: Study, found: Sequence[Judged], word: str) -> list[Section]:
    """The last sections of a page: points that gave no objective, and what was asked for."""
    failed = [(str(each.number), each.reason) for each in found if each.reason is not None]
    text = f"The first {MOST_FAILED} of {len(failed)}." if len(failed) > MOST_FAILED else ""
    table = PageTable((word, "reason"), failed[:MOST_FAILED])
    rows = [
        ("controller", study.controller.name),
        ("duty cycles", ", ".join(scenario.name for scenario in study.scenarios)),
        ("mismatches", ", ".join(mismatch.name for mismatch in study.mismatches)),
        *(("objective", each.title) for each in study.objectives),
        *((c.title, f"at most {c.at_most:g}") for c in study.constraints),
        *((axis.name, _range(axis)) for axis in study.axes),
        ("seed", str(study.seed)),
    ]
    asked = Section("Study", table=PageTable(("", "as the study file says"), rows))
    without = Section(f"{word.capitalize()}s without an objective", text, table)
    return [without, asked] if failed else [asked]


def _range(axis: Axis) -> str:
    if axis.choice:
        return f"one of {', '.join(map(axis.shown, axis.choice))}"
    return f"{axis.shown(axis.low, axis.high)}{', on a logarithmic scale' if axis.log else ''}"

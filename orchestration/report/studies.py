"""The reports of tuning (how it went, what mattered, the winner) and of sweeps."""

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
"""Points that the parallel coordinates of a sweep show; the table holds them all."""


def write_tuning(tuned: Tuned, path: Path) -> None:
    """Write `report.html` of a tuning study."""
    study, trials, winner = tuned.study, tuned.trials, tuned.best
    complete = [trial for trial in trials if trial.reason is None]
    sections = []
    if winner is not None:
        point = winner.point
        rows = [(axis.name, axis.shown(point[axis.name]), axis.shown(axis.shipped)) for axis in study.axes]
        table = PageTable(("parameter", "winner", "as shipped"), rows)
        sections.append(Section("Winner", f"{tuned.gain.capitalize()}.", table))
    if len(study.objectives) > 1 and complete:
        sections.append(_front(study, trials, "trial"))
    sections.append(_history(study, trials, tuned.polished))
    importance = _importance(tuned.storage) if len(complete) > 1 and len(study.axes) > 1 else None
    if importance is not None:
        text = "Share of the objective's variation that each parameter explains among the better trials "
        text += "(PED-ANOVA)."
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
        sections.append(_parallel_coordinates(study, complete[:MOST_LINES]))
        sections += [Section(axis.name, figure=_over(study, axis, complete)) for axis in study.axes]
        objectives = [evaluation.objective for evaluation in complete]
        span = f"from {min(objectives):.4g} to {max(objectives):.4g} over {len(complete)} points"
        lead = f"{study.objective.title} {span}."
    write_page(path, study.title, lead, [*sections, *_closing(study, found, "point")])


def _parallel_coordinates(study: Study, found: Sequence[Judged], text: str = "") -> Section:
    """Section with an axis for each parameter and each objective, a line for each point."""
    objectives, titles = [each.objective for each in found], [_axis(each) for each in study.objectives]
    values = [
        *(
            (_label(axis), [axis.readable[1] * each.point[axis.name] for each in found])
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


def _axis(objective: Gathered) -> str:
    """An objective with the unit of its metric."""
    unit = next(unit for end, unit in UNITS.items() if objective.metric.endswith(f"_{end}"))
    return f"{objective.title} [{unit}]"


def _label(axis: Axis) -> str:
    """A parameter without its instance, with the unit in which it is shown."""
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
    x: dict[str, Any] = {"title": _label(axis)}
    if axis.log:
        ticks = [float(f"{factor * level:.2g}") for level in axis.levels(5)]
        x |= {"type": "log", "tickvals": ticks, "ticktext": [f"{tick:g}" for tick in ticks]}
    marks = _points([factor * each.point[axis.name] for each in complete], complete, "point")
    return chart(*marks, x=x, y=_axis(study.objective), height=300)


def _front(study: Study, found: Sequence[Judged], word: str) -> Section:
    kept, (first, second) = front(found), [_axis(each) for each in study.objectives]
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
    steps = [(number, least) for number, least in enumerate(reached) if least < math.inf]
    star = {"color": COLOURS[3], "symbol": "star", "size": 14}
    look: dict[str, Any] = {"mode": "markers", "marker": star, "name": "winner, polished"}
    winner = [] if polished is None else [{"x": [polished.number], "y": [polished.objective], **look}]
    figure = chart(
        *_points([trial.number for trial in trials], trials, "trial"),
        *winner,
        _line([number for number, _ in steps], [least for _, least in steps], "hv", "best so far"),
        x="number of the trial [1]",
        y=_axis(study.objective),
    )
    text = "Each trial's objective, and the least of those that keep every constraint so far."
    return Section("Trials", text, figure=figure)


def _importance(storage: Storage) -> Any:
    """Importance of each parameter; None where the trials do not tell."""
    import optuna

    evaluator = optuna.importance.PedAnovaImportanceEvaluator()
    # Optuna wants to be told which of two objectives, and warns that it is to be small, as it is.
    target = None if len(storage.study.directions) == 1 else lambda trial: trial.values[0]
    warnings.filterwarnings("ignore", message="PedAnovaImportanceEvaluator computes")
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
    poisoned = [(str(i), each.reason) for i, each in enumerate(found) if each.reason is not None]
    heading, table = (
        f"{word.capitalize()}s without an objective",
        PageTable((word, "because"), poisoned[:100]),
    )
    rows = [
        ("controller", study.controller.name),
        ("duty cycles", ", ".join(scenario.name for scenario in study.scenarios)),
        ("mismatches", ", ".join(mismatch.name for mismatch in study.mismatches)),
        *(("objective", each.title) for each in study.objectives),
        *((f"{c.title}", f"at most {c.at_most:g}") for c in study.constraints),
        *((axis.name, _range(axis)) for axis in study.axes),
        ("seed", str(study.seed)),
    ]
    asked = Section("Study", table=PageTable(("", "as the study file says"), rows))
    return [Section(heading, table=table), asked] if poisoned else [asked]


def _range(axis: Axis) -> str:
    if axis.choice:
        return f"one of {', '.join(map(axis.shown, axis.choice))}"
    return f"{axis.shown(axis.low, axis.high)}{', by its logarithm' if axis.log else ''}"

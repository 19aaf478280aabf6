"""The reports of tuning (how it went, what mattered, the winner), of sweeps, and of comparisons."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from itertools import accumulate
from pathlib import Path
from typing import Any

from warmlink.orchestration.report.figures import COLOURS, chart, heat_map
from warmlink.orchestration.report.page import Section, Table, write_page
from warmlink.orchestration.scenarios import mismatch as mismatches
from warmlink.orchestration.scenarios.mismatch import NOMINAL
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER
from warmlink.orchestration.studies.axis import Axis
from warmlink.orchestration.studies.compare import Comparison, Row
from warmlink.orchestration.studies.points import Judged, front
from warmlink.orchestration.studies.storage import Storage
from warmlink.orchestration.studies.study import Study
from warmlink.orchestration.studies.tune import Tuned

MOST_LINES = 5000
"""Points that the parallel coordinates of a sweep show; the table holds them all."""


_HEADINGS = (
    "controller",
    "duty cycle",
    "mismatch",
    "largest [µm]",
    "95 % below [µm]",
    "within tolerance from [min]",
    "removed [%]",
    "equal within [µm]",
    "",
)


def write_tuning(tuned: Tuned, path: Path) -> None:
    """Write `report.html` of a tuning study."""
    study, trials, winner = tuned.study, tuned.trials, tuned.best
    complete = [trial for trial in trials if trial.reason is None]
    sections = []
    if winner is not None:
        point = winner.point
        rows = [(axis.name, axis.shown(point[axis.name]), axis.shown(axis.shipped)) for axis in study.axes]
        table = Table(("parameter", "winner", "as shipped"), rows)
        sections.append(Section("Winner", f"{tuned.gain.capitalize()}.", table))
    if len(study.objectives) > 1 and complete:
        sections.append(_front(study, trials, "trial"))
    sections.append(_history(study, trials))
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
    objectives, titles = [each.objective for each in found], [each.title for each in study.objectives]
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
    return chart(*marks, x=x, y=study.objective.title, height=300)


def _front(study: Study, found: Sequence[Judged], word: str) -> Section:
    kept, (first, second) = front(found), [each.title for each in study.objectives]
    rows = []
    for each in kept:
        point = [axis.shown(each.point[axis.name]) for axis in study.axes]
        rows.append((str(each.number), *(f"{value:.4g}" for value in each.objectives), *point))
    marks = _points([each.objectives[-1] if each.objectives else 0.0 for each in found], found, word)
    edge = _line([each.objectives[-1] for each in kept], [each.objective for each in kept], "vh", "front")
    table = Table((word, first, second, *(axis.name for axis in study.axes)), rows)
    text = (
        f"The {word}s that no other one betters in both objectives; the best is closest to the least of both."
    )
    return Section("Front", text, table, chart(*marks, edge, x=second, y=first))


def _history(study: Study, trials: list[Judged]) -> Section:
    reached = accumulate((each.objective if each.feasible else math.inf for each in trials), min)
    steps = [(number, least) for number, least in enumerate(reached) if least < math.inf]
    figure = chart(
        *_points([trial.number for trial in trials], trials, "trial"),
        _line([number for number, _ in steps], [least for _, least in steps], "hv", "best so far"),
        x="trial",
        y=study.objective.title,
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
    return chart({"x": shares, "y": names, **look}, x="share", y=down, height=260)


def _closing(study: Study, found: Sequence[Judged], word: str) -> list[Section]:
    """The last sections of a page: points that gave no objective, and what was asked for."""
    poisoned = [(str(i), each.reason) for i, each in enumerate(found) if each.reason is not None]
    heading, table = f"{word.capitalize()}s without an objective", Table((word, "because"), poisoned[:100])
    rows = [
        ("controller", study.controller.name),
        ("duty cycles", ", ".join(scenario.name for scenario in study.scenarios)),
        ("mismatches", ", ".join(mismatch.name for mismatch in study.mismatches)),
        *(("objective", each.title) for each in study.objectives),
        *((f"{c.title}", f"at most {c.at_most:g}") for c in study.constraints),
        *((axis.name, _range(axis)) for axis in study.axes),
        ("seed", str(study.seed)),
    ]
    asked = Section("Study", table=Table(("", "as the study file says"), rows))
    return [Section(heading, table=table), asked] if poisoned else [asked]


def _range(axis: Axis) -> str:
    if axis.choice:
        return f"one of {', '.join(map(axis.shown, axis.choice))}"
    return f"{axis.shown(axis.low, axis.high)}{', by its logarithm' if axis.log else ''}"


def write_comparison(comparison: Comparison, path: Path) -> None:
    """Write `report.html`."""
    sections = []
    controllers, duties = comparison.controllers, comparison.duty_cycles
    if NOMINAL in comparison.mismatches:
        rows = [[comparison.row(name, duty) for name in controllers] for duty in duties]
        sections.append(_map("Every parameter as the controllers assume it", rows, duties))
    others = [name for name in comparison.mismatches if name != NOMINAL]
    if others:
        rows = [[comparison.worst(name, [duty], others) for name in controllers] for duty in duties]
        text = f"Worst of {', '.join(others)}, which the pointer names."
        sections.append(_map("Worst mismatch of each cell", rows, duties, text))
        every = comparison.mismatches
        rows = [[comparison.worst(name, duties, [mismatch]) for name in controllers] for mismatch in every]
        text = "Worst of all duty cycles, which the pointer names."
        sections.append(_map("Mismatch by mismatch", rows, every, text))
    differing = [(name, _about(name)) for name in comparison.mismatches]
    sections += [
        Section(
            "Productive minutes won against warming up first",
            "Minutes within tolerance, less those that warming up first gives: no compensation, and the zero "
            "set once, at the moment that suits that duty cycle best.",
            table=_won(comparison),
        ),
        Section("Mismatches", table=Table(("mismatch", "what differs"), differing)),
        Section(
            "Every run",
            "Equal within: bound of the coupling error by a run with half the step, plus the link's own "
            "estimate of its grid's error. Scores that differ by less are equal.",
            table=Table(_HEADINGS, [_cells(row) for row in comparison.rows.values()]),
        ),
    ]
    write_page(path, "Controllers compared", _lead(comparison), sections)


def _lead(comparison: Comparison) -> str:
    size = len(comparison.duty_cycles) * len(comparison.mismatches)
    kept = {
        name: size - sum(row.defeated for row in comparison.rows.values() if row.controller == name)
        for name in comparison.controllers
        if name != NO_CONTROLLER
    }
    parts = [f"{name} stays within tolerance in {count} of {size} runs" for name, count in kept.items()]
    return "; ".join(parts) + "." if parts else "No controller was asked for beside none."


def worst_errors(comparison: Comparison) -> Any:
    """Heat map of the largest errors over all mismatches, of each controller in each duty cycle."""
    duties, controllers, every = comparison.duty_cycles, comparison.controllers, comparison.mismatches
    return _largest(
        [[comparison.worst(name, [duty], every) for name in controllers] for duty in duties], duties
    )


def _map(heading: str, rows: list[list[Row]], names: Sequence[str], text: str = "") -> Section:
    """Section with the heat map of the largest errors."""
    what = "Largest error in µm, and the share of the uncompensated one that was removed."
    return Section(heading, f"{what} {text}".strip(), figure=_largest(rows, names))


def _largest(rows: list[list[Row]], names: Sequence[str]) -> Any:
    """Heat map of the largest errors, a column for each controller and a named line for each of the rows."""
    figure = heat_map(
        [row.controller for row in rows[0]],
        names,
        [[row.outcome.max_abs_um for row in line] for line in rows],
        [[_cell(row) for row in line] for line in rows],
        rows[0][0].tolerance_um,
        "µm",
    )
    figure.update_traces(
        customdata=[[f"{row.duty_cycle}, {row.mismatch}" for row in line] for line in rows],
        hovertemplate="%{x}: %{text}<br>%{customdata}<extra></extra>",
    )
    return figure


def _cell(row: Row) -> str:
    if row.outcome.stopped is not None:
        return "stopped"
    error = f"{row.outcome.max_abs_um:.1f}"
    if row.controller == NO_CONTROLLER or row.removed_percent is None:
        return error
    return f"{error}<br>{row.removed_percent:.0f} %"


def _won(comparison: Comparison) -> Table:
    mismatch = NOMINAL if NOMINAL in comparison.mismatches else comparison.mismatches[0]
    lines = []
    for duty in comparison.duty_cycles:
        rows = [comparison.row(name, duty, mismatch) for name in comparison.controllers]
        best = f"{rows[0].outcome.warm_up_first_min:.0f}"
        lines.append((duty, best, *(f"{row.minutes_won:+.0f}" for row in rows)))
    return Table((f"duty cycle ({mismatch})", "warming up first", *comparison.controllers), lines)


def _about(name: str) -> str:
    known = name in mismatches.names() or name.startswith("draw_")
    return mismatches.load(name).about if known else "from a file"


def _cells(row: Row) -> tuple[str, ...]:
    found, run = row.outcome, (row.controller, row.duty_cycle, row.mismatch)
    if found.stopped is not None:
        return (*run, *("",) * 5, f"stopped: {found.stopped}")
    settled, removed, equal = found.time_to_tolerance_s, row.removed_percent, row.equal_within_um
    remark = "worse than none" if row.worse_than_none else "beyond tolerance" if row.beyond_tolerance else ""
    return (
        *(*run, f"{found.max_abs_um:.2f}", f"{found.p95_abs_um:.2f}"),
        "never" if settled is None else f"{settled / 60:.1f}",
        "" if removed is None else f"{removed:.1f}",
        "" if equal is None else f"{equal:.2g}",
        remark,
    )

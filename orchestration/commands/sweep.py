"""`warmlink sweep`: a grid or a Latin hypercube of start values in closed loop."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from warmlink.orchestration.commands.console import answer, answer_json, progress_bar, remark
from warmlink.orchestration.commands.study import INTERRUPTED, KEPT, interruptible, means, results
from warmlink.orchestration.studies.points import Evaluation
from warmlink.orchestration.studies.study import Study, load_study
from warmlink.orchestration.studies.sweep import points_of, sweep, write_parquet


def sweep_command(
    place: str,
    scheduler: str | None,
    jobs: int,
    fmus: str | None,
    out: Path | None,
    report: bool,
    as_json: bool,
) -> int:
    """Sweep, write and answer; gives the exit code."""
    study = load_study(place)
    points = points_of(study)
    folder = out or Path("out") / study.name / "sweep"
    try:
        own = () if study.own is None else (study.own,)
        with interruptible(), means(study.kinds, study.foreign, own, fmus, scheduler, jobs, folder) as given:
            with progress_bar(study.title) as progress:
                found = sweep(study, points, given.workers, lambda done: progress(done / len(points)))
            with results(folder) as target:
                write_parquet(study, found, target / "sweep.parquet")
                if report:
                    from warmlink.orchestration.report.sweep import write_report

                    write_report(study, found, target / "report.html")
    except KeyboardInterrupt:
        remark(KEPT)
        return INTERRUPTED
    if as_json:
        answer_json(_figures(study, found))
    else:
        answer(_answer(study, found))
        answer(f"table   {folder / 'sweep.parquet'}")
        if report:
            answer(f"report  {folder / 'report.html'}")
    return 0


def _best(found: list[Evaluation]) -> int | None:
    feasible = [i for i, evaluation in enumerate(found) if evaluation.feasible]
    return min(feasible, key=lambda i: (found[i].objective, i), default=None)


def _answer(study: Study, found: list[Evaluation]) -> str:
    lines = [f"{study.title} · {study.controller} · {len(found)} points of {len(study.runs)} runs"]
    leader = _best(found)
    if leader is not None:
        objectives = [evaluation.objective for evaluation in found if evaluation.reason is None]
        lines.append(f"{study.objective.title}: from {min(objectives):.4g} to {max(objectives):.4g}")
        lines.append(f"smallest that keeps every constraint: {found[leader].objective:.4g}, point {leader}")
        lines += [
            f"  {axis.name:<36}{found[leader].point[axis.name]:>14.6g} {axis.unit}" for axis in study.axes
        ]
    poisoned = [evaluation for evaluation in found if evaluation.reason is not None]
    if poisoned:
        lines.append(f"{len(poisoned)} points gave no objective, the first because of: {poisoned[0].reason}")
    return "\n".join(lines)


def _figures(study: Study, found: list[Evaluation]) -> dict[str, Any]:
    return {
        "study": study.name,
        "objective": study.objective.title,
        "best": _best(found),
        "units": {axis.name: axis.unit for axis in study.axes},
        "points": [
            {
                "parameters": dict(evaluation.point),
                "objective": None if math.isnan(evaluation.objective) else evaluation.objective,
                "feasible": evaluation.feasible,
                "reason": evaluation.reason,
            }
            for evaluation in found
        ],
    }

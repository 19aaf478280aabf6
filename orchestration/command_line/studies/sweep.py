"""`warmlink sweep`: run a grid or a Latin hypercube of parameters in closed loop."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from warmlink.orchestration.command_line.options import Fmus, Jobs, Json, Report, Scheduler, StudyFile
from warmlink.orchestration.console import answer, answer_json, progress_bar

if TYPE_CHECKING:
    from warmlink.orchestration.studies.points import Judged
    from warmlink.orchestration.studies.study import Study


def sweep(
    study: StudyFile,
    scheduler: Scheduler = None,
    jobs: Jobs = 2,
    fmus: Fmus = None,
    out: Annotated[Path | None, typer.Option(help="Folder for results. Default: out/STUDY/sweep.")] = None,
    report: Report = True,
    json: Json = False,
) -> None:
    """Run a grid or a Latin hypercube of parameters in closed loop.

    Takes the same study files as `warmlink tune`. Their table [sweep] says `kind = "grid"` with the number of
    `points` for each parameter, or `kind = "latin_hypercube"` with the total number of `points`. Writes
    sweep.parquet, with one row for each run, and report.html. After an interruption the same command
    continues.
    """
    from warmlink.orchestration.command_line.studies.in_order import interruptible, results
    from warmlink.orchestration.fmu_store import kind_named
    from warmlink.orchestration.studies.at_work import Means, at_work
    from warmlink.orchestration.studies.points import best
    from warmlink.orchestration.studies.study import load_study
    from warmlink.orchestration.studies.sweep import points_of, write_parquet
    from warmlink.orchestration.studies.sweep import sweep as sweep_study

    asked = load_study(study)
    points = points_of(asked)
    folder, means = out or Path("out") / asked.name / "sweep", Means(kind_named(fmus), jobs, scheduler)
    with interruptible(), at_work(asked.scenarios, means, folder) as work:
        with progress_bar(asked.title) as progress:
            found = sweep_study(asked, points, work.workers, lambda done: progress(done / len(points)))
        with results(folder) as target:
            write_parquet(asked, found, target / "sweep.parquet")
            if report:
                from warmlink.orchestration.report.sweep import write_report

                write_report(asked, found, target / "report.html")
    if json:
        answer_json(_figures(asked, found, best(found)))
        return
    answer(_answer(asked, found, best(found)))
    answer(f"table   {folder / 'sweep.parquet'}")
    if report:
        answer(f"report  {folder / 'report.html'}")


def _answer(study: Study, found: list[Judged], leader: Judged | None) -> str:
    lines = [f"{study.title} · {study.controller.name} · {len(found)} points of {len(study.runs)} runs"]
    if leader is not None:
        objectives = [evaluation.objective for evaluation in found if evaluation.reason is None]
        smallest = f"{leader.objective:.4g}, point {found.index(leader)}"
        lines.append(f"{study.objective.title}: from {min(objectives):.4g} to {max(objectives):.4g}")
        lines.append(f"smallest of the points that meet every constraint: {smallest}")
        lines += study.lines(leader.point)
    poisoned = [evaluation for evaluation in found if evaluation.reason is not None]
    if poisoned:
        lines.append(f"{len(poisoned)} points gave no objective, the first because of: {poisoned[0].reason}")
    return "\n".join(lines)


def _figures(study: Study, found: list[Judged], leader: Judged | None) -> dict[str, Any]:
    return {
        "study": study.name,
        "objective": study.objective.title,
        "best": None if leader is None else found.index(leader),
        "units": {axis.name: axis.unit for axis in study.axes},
        "points": [evaluation.to_dict() for evaluation in found],
    }

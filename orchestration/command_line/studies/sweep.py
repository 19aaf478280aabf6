"""`warmlink sweep`: run a grid or a Latin hypercube of parameters in closed loop."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warmlink.orchestration.command_line.options import Exact, Fmus, Jobs, Json, Report, Scheduler, StudyFile
from warmlink.orchestration.console import answer, answer_json, progress_bar


def sweep(
    study: StudyFile,
    scheduler: Scheduler = None,
    jobs: Jobs = 2,
    fmus: Fmus = None,
    out: Annotated[Path | None, typer.Option(help="Folder for results. Default: out/STUDY/sweep.")] = None,
    exact: Exact = False,
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
    from warmlink.orchestration.studies.points import Searched
    from warmlink.orchestration.studies.study import load_study
    from warmlink.orchestration.studies.sweep import points_of, write_parquet
    from warmlink.orchestration.studies.sweep import sweep as sweep_study

    asked = load_study(study)
    points = points_of(asked)
    folder, means = out or Path("out") / asked.name / "sweep", Means(kind_named(fmus), jobs, scheduler, exact)
    with interruptible(), at_work(asked.scenarios, means, folder) as work:
        with progress_bar(asked.title) as progress:
            found = sweep_study(asked, points, work.workers, lambda done: progress(done / len(points)))
        with results(folder) as target:
            write_parquet(asked, found, target / "sweep.parquet")
            if report:
                from warmlink.orchestration.report.studies import write_sweep

                write_sweep(asked, found, target / "report.html")
    if json:
        answer_json(Searched(asked, found).to_dict())
        return
    answer(Searched(asked, found).summary())
    answer(f"table   {folder / 'sweep.parquet'}")
    if report:
        answer(f"report  {folder / 'report.html'}")

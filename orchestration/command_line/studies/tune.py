"""`warmlink tune`: find the best parameters of a controller with Optuna, in closed loop."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warmlink.orchestration.command_line.options import Exact, Fmus, Jobs, Json, Report, Scheduler, StudyFile
from warmlink.orchestration.console import answer, answer_json, noted_progress_bar

if TYPE_CHECKING:
    from warmlink.orchestration.studies.points import Judged


def tune(
    study: StudyFile,
    trials: Annotated[
        int | None, typer.Option(help="Number of trials. Default: the number in the study file.")
    ] = None,
    scheduler: Scheduler = None,
    jobs: Jobs = 2,
    fmus: Fmus = None,
    out: Annotated[Path | None, typer.Option(help="Folder for results. Default: out/STUDY/tune.")] = None,
    exact: Exact = False,
    report: Report = True,
    json: Json = False,
) -> None:
    """Find a controller's best parameters with Optuna; each trial is judged in closed loop.

    The study file says which parameters vary between which bounds, over which duty cycles and mismatches the
    controller is judged, which figure is minimised (its worst value, its mean, or the mean of its worst
    share), and which limits must be kept:

        controller = "lag"
        duty_cycles = ["windshield_wiper", "stop_and_go"]
        [parameters]
        "compensator.gain" = { min = "2 um/W", max = "8 um/W" }
        [objective]
        metric = "max_abs_um"
        over = "worst"

    A table [second_objective] of the same kind asks for the Pareto front of both. Where the system is joined,
    the winner is polished along its gradient.

    Writes trials.csv, winner.ssv and report.html. After an interruption the same command continues; its table
    does not depend on the number of processes.
    """
    from warmlink.orchestration.command_line.studies.in_order import interruptible, results
    from warmlink.orchestration.fmu_store import kind_named
    from warmlink.orchestration.studies.at_work import Means, at_work
    from warmlink.orchestration.studies.storage import Storage, default_url, import_optuna
    from warmlink.orchestration.studies.study import load_study
    from warmlink.orchestration.studies.tune import tune as tune_study
    from warmlink.orchestration.studies.winner import write_winner

    import_optuna()
    asked = load_study(study).lasting(trials)
    folder, means = out or Path("out") / asked.name / "tune", Means(kind_named(fmus), jobs, scheduler, exact)
    with interruptible(), at_work(asked.scenarios, means, folder) as work:
        storage = Storage(asked, work.fmus.digest, asked.tune.storage or default_url(folder))
        with noted_progress_bar(asked.title) as show:
            found = tune_study(
                asked,
                work.workers,
                storage,
                lambda done, leader: show(done / asked.tune.trials, _note(leader)),
                joined=work.joins(asked.controller),
            )
        with results(folder) as target:
            found.to_frame().to_csv(target / "trials.csv", index=False, lineterminator="\n")
            if found.best is not None:
                write_winner(asked, found.best.point, target)
            if report:
                from warmlink.orchestration.report.studies import write_tuning

                write_tuning(found, storage, target / "report.html")
    if json:
        answer_json(found.to_dict())
        return
    answer(found.summary())
    answer(f"trials  {folder / 'trials.csv'}")
    answer(f"study   optuna-dashboard {storage.place}")
    if report:
        answer(f"report  {folder / 'report.html'}")


def _note(leader: Judged | None) -> str:
    return "" if leader is None else f"best {leader.objective:.4g} (trial {leader.number})"

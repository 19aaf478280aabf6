"""`warmlink tune`: the best start values by Optuna, in closed loop."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.console import answer, answer_json, noted_progress_bar
from warmlink.orchestration.command_line.options import Fmus, Jobs, Json, Report, Scheduler, StudyFile

if TYPE_CHECKING:
    from warmlink.orchestration.studies.study import Study
    from warmlink.orchestration.studies.tune import Trial


def tune(
    study: StudyFile,
    trials: Annotated[int | None, typer.Option(help="How many trials. Default: what the study says.")] = None,
    scheduler: Scheduler = None,
    jobs: Jobs = 2,
    fmus: Fmus = None,
    out: Annotated[Path | None, typer.Option(help="Folder for results. Default: out/STUDY/tune.")] = None,
    report: Report = True,
    json: Json = False,
) -> None:
    """Find a controller's best parameters with Optuna, judged in closed loop.

    The study file says what to vary between which bounds, over which duty cycles and mismatches, which figure
    to make small (its worst value, its mean, or the mean of its worst share) and what must not be exceeded:

        controller = "lag"
        duty_cycles = ["windshield_wiper", "stop_and_go"]
        [parameters]
        "compensator.gain" = { min = "2 um/W", max = "8 um/W" }
        [objective]
        metric = "max_abs_um"
        over = "worst"

    Writes trials.csv, winner.ssv and report.html. After an interruption the same command continues; its table
    does not depend on the number of processes.
    """
    from warmlink.orchestration.commands.study import interruptible, means, results
    from warmlink.orchestration.studies.points import best
    from warmlink.orchestration.studies.storage import Storage, default_url, import_optuna
    from warmlink.orchestration.studies.study import load_study
    from warmlink.orchestration.studies.tune import tune as tune_study
    from warmlink.orchestration.studies.winner import write_winner

    import_optuna()
    asked = load_study(study)
    if trials is not None:
        if trials < 1:
            raise InputError(f"--trials {trials}: not a number of trials; give 1 or more")
        asked = replace(asked, tune=replace(asked.tune, trials=trials))
    folder = out or Path("out") / asked.name / "tune"
    own = () if asked.own is None else (asked.own,)
    with interruptible(), means(asked.kinds, asked.foreign, own, fmus, scheduler, jobs, folder) as given:
        storage = Storage(asked, given.fmus.digest, asked.tune.storage or default_url(folder))
        with noted_progress_bar(asked.title) as show:
            found = tune_study(
                asked,
                given.workers,
                storage,
                lambda done, leader: show(done / asked.tune.trials, _note(leader)),
            )
        winner = best(found)
        with results(folder) as target:
            _write_trials(asked, found, target / "trials.csv")
            if winner is not None:
                write_winner(asked, winner.point, target)
            if report:
                from warmlink.orchestration.report.tuning import write_report

                write_report(asked, storage, found, target / "report.html")
    if json:
        answer_json(_figures(asked, found, winner))
        return
    answer(_answer(asked, found, winner))
    answer(f"trials  {folder / 'trials.csv'}")
    if report:
        answer(f"report  {folder / 'report.html'}")


def _note(leader: Trial | None) -> str:
    return "" if leader is None else f"best {leader.objective:.4g} (trial {leader.number})"


def _answer(study: Study, trials: list[Trial], winner: Trial | None) -> str:
    poisoned = [trial for trial in trials if trial.reason is not None]
    unfit = sum(trial.reason is None and not trial.feasible for trial in trials)
    head = f"{study.title} · {study.controller} · {len(trials)} trials of {len(study.runs)} runs"
    lines = [head]
    if winner is None:
        lines.append("no trial keeps every constraint")
    else:
        first = trials[0]
        shipped = f", {first.objective:.4g} as shipped" if study.shipped and first.reason is None else ""
        lines.append(f"{study.objective.title}: {winner.objective:.4g} at best{shipped}")
        lines += study.lines(winner.point)
    if unfit:
        lines.append(f"{unfit} trials break a constraint")
    if poisoned:
        lines.append(f"{len(poisoned)} trials gave no objective, the first because of: {poisoned[0].reason}")
    return "\n".join(lines)


def _figures(study: Study, trials: list[Trial], winner: Trial | None) -> dict[str, Any]:
    return {
        "study": study.name,
        "objective": study.objective.title,
        "best": None if winner is None else winner.to_dict(),
        "units": {axis.name: axis.unit for axis in study.axes},
        "trials": [trial.to_dict() for trial in trials],
    }


def _write_trials(study: Study, trials: list[Trial], path: Path) -> None:
    excesses = [f"{c.metric} above {c.at_most:g}" for c in study.constraints]
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        headings = [axis.heading for axis in study.axes]
        writer.writerow(["number", *headings, "objective", "feasible", *excesses, "reason"])
        for trial in trials:
            excess = [repr(value) for value in trial.excess] or [""] * len(excesses)
            objective = "" if trial.reason is not None else repr(trial.objective)
            values = [repr(trial.point[axis.name]) for axis in study.axes]
            feasible = int(trial.feasible)
            writer.writerow([trial.number, *values, objective, feasible, *excess, trial.reason or ""])

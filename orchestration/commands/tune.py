"""`warmlink tune`: the best start values by Optuna, in closed loop."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.commands.console import answer, answer_json, noted_progress_bar, remark
from warmlink.orchestration.commands.study import INTERRUPTED, KEPT, interruptible, means, results
from warmlink.orchestration.studies.storage import Storage, default_url, import_optuna
from warmlink.orchestration.studies.study import Study, load_study
from warmlink.orchestration.studies.tune import Trial, best, tune
from warmlink.orchestration.studies.winner import write_winner


def tune_command(
    place: str,
    trials: int | None,
    scheduler: str | None,
    jobs: int,
    fmus: str | None,
    out: Path | None,
    report: bool,
    as_json: bool,
) -> int:
    """Tune, write and answer; gives the exit code."""
    import_optuna()
    study = load_study(place)
    if trials is not None:
        if trials < 1:
            raise InputError(f"--trials {trials}: not a number of trials; give 1 or more")
        study = replace(study, tune=replace(study.tune, trials=trials))
    folder = out or Path("out") / study.name / "tune"
    try:
        own = () if study.own is None else (study.own,)
        with interruptible(), means(study.kinds, study.foreign, own, fmus, scheduler, jobs, folder) as given:
            url = study.tune.storage or default_url(folder)
            storage = Storage(study, given.fmus.digest, url)
            with noted_progress_bar(study.title) as show:
                found = tune(
                    study,
                    given.workers,
                    storage,
                    lambda done, leader: show(done / study.tune.trials, _note(study, leader)),
                )
            winner = best(found)
            with results(folder) as target:
                _write_trials(study, found, target / "trials.csv")
                if winner is not None:
                    write_winner(study, winner.point, target)
                if report:
                    from warmlink.orchestration.report.tuning import write_report

                    write_report(study, storage, found, target / "report.html")
    except KeyboardInterrupt:
        remark(KEPT)
        return INTERRUPTED
    if as_json:
        answer_json(_figures(study, found, winner))
    else:
        answer(_answer(study, found, winner))
        answer(f"trials  {folder / 'trials.csv'}")
        if report:
            answer(f"report  {folder / 'report.html'}")
    return 0


def _note(study: Study, leader: Trial | None) -> str:
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
        lines += [f"  {axis.name:<36}{winner.point[axis.name]:>14.6g} {axis.unit}" for axis in study.axes]
    if unfit:
        lines.append(f"{unfit} trials break a constraint")
    if poisoned:
        lines.append(f"{len(poisoned)} trials gave no objective, the first because of: {poisoned[0].reason}")
    return "\n".join(lines)


def _figures(study: Study, trials: list[Trial], winner: Trial | None) -> dict[str, Any]:
    return {
        "study": study.name,
        "objective": study.objective.title,
        "best": None if winner is None else _trial(winner),
        "units": {axis.name: axis.unit for axis in study.axes},
        "trials": [_trial(trial) for trial in trials],
    }


def _trial(trial: Trial) -> dict[str, Any]:
    return {
        "number": trial.number,
        "parameters": dict(trial.point),
        "objective": None if math.isnan(trial.objective) else trial.objective,
        "feasible": trial.feasible,
        "reason": trial.reason,
    }


def _write_trials(study: Study, trials: list[Trial], path: Path) -> None:
    excesses = [f"{c.figure.metric} above {c.at_most:g}" for c in study.constraints]
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

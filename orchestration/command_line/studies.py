"""`warmlink tune` and `sweep`: many scenarios, run on all cores or on a cluster."""

from __future__ import annotations

import logging
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import (
    FAILED,
    Terminated,
    answer,
    answer_json,
    interrupted,
)
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.results import refuse_others, results_folder
from warmlink.orchestration.shell import command

if TYPE_CHECKING:
    from warmlink.orchestration.studies.points import Searched
    from warmlink.orchestration.studies.session import RunOptions
    from warmlink.orchestration.studies.tune import Tuned

COMMANDS = ("tune", "sweep")


def tune(
    study: str,
    *,
    trials: int | None = None,
    scheduler: str | None = None,
    jobs: int = 2,
    fmus: str | None = None,
    out: Path | None = None,
    exact: bool = False,
    report: bool = True,
    json: bool = False,
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

    Writes trials.csv, winner.ssv and report.html; the first after each batch of trials. Where no trial keeps
    every constraint there is no winner: the trial that comes nearest is named, and the exit code is 1. After
    an interruption the same command continues; its table does not depend on the number of processes.

    Parameters
    ----------
    trials : Number of trials. Default: the number in the study file.
    out : Folder for results. Default: out/STUDY/tune.
    """
    from warmlink.orchestration.studies.study import load_study
    from warmlink.orchestration.studies.tune import TRIALS, tuned
    from warmlink.orchestration.studies.winner import write_winner

    asked = load_study(study).lasting(trials)
    folder = out or Path("out") / asked.name / "tune"
    refuse_others(folder, "tune")
    options = run_options(fmus, jobs, scheduler, exact)

    def keep(folder: Path, found: Tuned) -> None:
        with kept_results(folder, "tune") as target:  # which keeps those of another command line from now on
            found.write_csv(target / TRIALS)

    with (
        interruptible(),
        tuned(asked, options, folder, keep) as found,
        kept_results(folder, "tune") as target,
    ):
        found.write_csv(target / TRIALS)
        if found.best is not None:
            write_winner(asked, found.best.point, target)
        if report:
            from warmlink.orchestration.report.studies import write_tuning

            write_tuning(found, target / "report.html")
    absent = "" if find_spec("optuna_dashboard") else "    first: pip install optuna-dashboard"
    table = f"trials  {folder / TRIALS}\nstudy   {dashboard(found.storage.place)}{absent}"
    _answer(found, table, folder, report, json)
    if found.best is None:
        raise SystemExit(FAILED)


def dashboard(place: str) -> str:
    """Line for a shell that shows the trials of a storage."""
    return command("optuna-dashboard", place)


def sweep(
    study: str,
    *,
    scheduler: str | None = None,
    jobs: int = 2,
    fmus: str | None = None,
    out: Path | None = None,
    exact: bool = False,
    report: bool = True,
    json: bool = False,
) -> None:
    """Run a grid or a Latin hypercube of parameters in closed loop.

    Takes the same study files as `warmlink tune`. Their table [sweep] says `kind = "grid"` with the number of
    `points` for each parameter, or `kind = "latin_hypercube"` with the total number of `points`. Writes
    sweep.parquet, with one row for each run, and report.html. After an interruption the same command
    continues.

    Parameters
    ----------
    out : Folder for results. Default: out/STUDY/sweep.
    """
    from warmlink.orchestration.studies.study import load_study
    from warmlink.orchestration.studies.sweep import swept

    asked = load_study(study)
    folder = out or Path("out") / asked.name / "sweep"
    refuse_others(folder, "sweep")
    options = run_options(fmus, jobs, scheduler, exact)
    with interruptible(), swept(asked, options, folder) as searched, kept_results(folder, "sweep") as target:
        searched.write(target / "sweep.parquet")
        if report:
            from warmlink.orchestration.report.studies import write_sweep

            write_sweep(asked, searched.found, target / "report.html")
    _answer(searched, f"table   {folder / 'sweep.parquet'}", folder, report, json)


def run_options(fmus: str | None, jobs: int, scheduler: str | None, exact: bool) -> RunOptions:
    """How the runs of a study are carried out, by the command's options."""
    from warmlink.orchestration.fmu_store import kind_named
    from warmlink.orchestration.studies.session import RunOptions

    return RunOptions(kind_named(fmus), jobs, scheduler, exact)


def _answer(found: Searched, files: str, folder: Path, report: bool, json: bool) -> None:
    if json:
        answer_json(found.to_dict())
        return
    answer(f"{found.summary()}\n{files}")
    if report:
        answer(f"report  {folder / 'report.html'}")


@contextmanager
def interruptible() -> Iterator[None]:
    """Let Ctrl-C or SIGTERM end the command in order, and a second one end the process at once.

    The worker processes end with this one. Python drops what is raised in the callback of a weak reference:
    therefore it is noted too, for the next run to see.
    """
    cells = under_way.here.cells

    def first(number: int, frame: FrameType | None) -> None:
        for each in (signal.SIGINT, signal.SIGTERM):
            signal.signal(each, signal.SIG_DFL)
        cells[under_way.ASKED] = 1
        # A storage would print where it was interrupted.
        logging.getLogger("sqlalchemy").setLevel(logging.CRITICAL)
        raise Terminated if number == signal.SIGTERM else KeyboardInterrupt

    try:
        with under_way.on_ctrl_c(first):
            yield
    except KeyboardInterrupt as fault:
        raise interrupted(fault, "finished runs are kept, and the same command continues") from None
    finally:
        cells[under_way.ASKED] = 0


@contextmanager
def kept_results(folder: Path, command: str) -> Iterator[Path]:
    """Yield a temporary folder to write results into; its files move to `folder` when all are written.

    InputError if the results cannot be written; the sentence says that the finished runs are kept.
    """
    kept = "every finished run is kept, and the same command writes the results"
    try:
        with results_folder(folder, command) as target:
            yield target
    except OSError as fault:
        raise InputError(
            f"{folder}: the results cannot be written ({fault.strerror or fault}); make room: {kept}"
        ) from None
    except InputError as fault:
        raise InputError(f"{fault}; {kept}") from None

"""`warmlink compare`, `tune` and `sweep`: many scenarios, run on all cores or on a cluster."""

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
from warmlink.orchestration.command_line import arguments
from warmlink.orchestration.command_line.comparison import legend, table
from warmlink.orchestration.console import (
    FAILED,
    Terminated,
    answer,
    answer_json,
    interrupted,
    print_table,
    remark,
)
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.results import refuse_others, results_folder
from warmlink.orchestration.shell import command

if TYPE_CHECKING:
    from warmlink.orchestration.studies.at_work import Means
    from warmlink.orchestration.studies.points import Searched
    from warmlink.orchestration.studies.tune import Tuned

WIDE = 240
"""Width in characters of the table where the output is not a terminal."""


def compare(
    *,
    controllers: str | None = None,
    duty_cycles: str | None = None,
    mismatch: str | None = None,
    with_: list[str] | None = None,
    parameters: list[Path] | None = None,
    set_: list[str] | None = None,
    fmus: str | None = None,
    system: str = "WarmupCell",
    scenario: Path | None = None,
    replace: list[str] | None = None,
    map_: list[str] | None = None,
    out: Path | None = None,
    scheduler: str | None = None,
    jobs: int = 2,
    exact: bool = False,
    report: bool = True,
    json: bool = False,
) -> None:
    """Compare controllers with each other and with no compensation, over duty cycles and mismatches.

    A --set of a compensator's parameter reaches every controller that has this parameter; mismatches are
    applied after all other changes. Writes compare.csv and report.html. After an interruption the same
    command continues. Differences within the error budget count as equal. The table marks where an error is
    beyond the tolerance, and where a controller is worse than none.

    With --scenario, a cell of one's own is compared in: its parameters and sensors hold in every duty cycle,
    and without --duty-cycles it is compared in its own.

    Example: `warmlink compare --controllers lag,observer --duty-cycles stop_and_go --mismatch nominal`

    Parameters
    ----------
    controllers : Controllers, such as `lag,observer`. Default: all (`warmlink list`).
    duty_cycles : Names of duty cycles, or TOML or CSV files of your own, separated by commas. Default: all,
        or that of the --scenario.
    mismatch : How the real cell differs from the one that the controllers were designed for: `nominal`,
        `thermal_high`, `thermal_low`, `insulated`, `ventilated`, `losses_high`, `losses_low`,
        `noisy_sensors`, `camera_absent`, `draw_1`, `draw_2` and so on (the number is the seed), or TOML
        files, separated by commas. Default: nine of them.
    with_ : A controller of your own, as `my_law.py:MyLaw`. Repeatable.
    system : `WarmupCell`, or `SixAxisArm`, for which a duty cycle is a program.
    scenario : A scenario (TOML) of a cell of your own: its parameters and sensors hold, and its duty cycle.
    out : Folder for results. Default: out/compare.
    """
    from warmlink.orchestration.scenarios.overrides import reached_controllers
    from warmlink.orchestration.scenarios.setup import with_replaced
    from warmlink.orchestration.studies.compare import compared, plan_on, write_csv
    from warmlink.orchestration.system.replacement import Replacements

    sets = arguments.sets_given(parameters, set_)
    laws, duties, wrong = (arguments.listed(each) for each in (controllers, duty_cycles, mismatch))
    plan = plan_on(system, laws, duties, wrong, sets, scenario, with_ or ())
    given = Replacements.given(replace, map_)
    plan = plan._replace(scenarios=tuple(with_replaced(each, given) for each in plan.scenarios))
    for each in sets:
        sentence = reached_controllers(each, plan.laws)
        if sentence is not None:
            remark(sentence)
    for first in {each.controller.name: each for each in plan.scenarios}.values():
        arguments.advise(first)
    folder = out or Path("out") / ("compare" if system == "WarmupCell" else f"compare_{system}")
    refuse_others(folder, "compare")
    means = _means(fmus, jobs, scheduler, exact)
    with interruptible(), compared(plan, means, folder) as comparison, _results(folder, "compare") as target:
        write_csv(comparison, target / "compare.csv")
        if report:
            from warmlink.orchestration.report.comparison import write_comparison

            write_comparison(comparison, target / "report.html")
    if json:
        answer_json(comparison.records())
    else:
        title = "largest error in µm, and the share of it removed"
        print_table(title, ("", *comparison.controllers), table(comparison), texts=1, width=WIDE)
        answer(f"{legend(comparison)}\ntable   {folder / 'compare.csv'}")
        if report:
            answer(f"report  {folder / 'report.html'}")
    stopped = [row for row in comparison.rows.values() if row.outcome.stopped is not None]
    for row in stopped[:3]:
        remark(f"{row.controller}, {row.duty_cycle}, {row.mismatch}: stopped early: {row.outcome.stopped}")
    if len(stopped) > 3:
        remark(f"{len(stopped) - 3} more runs stopped early")
    if stopped:
        raise SystemExit(FAILED)


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
    means = _means(fmus, jobs, scheduler, exact)

    def keep(so_far: Tuned) -> None:
        with _results(folder, "tune") as target:
            so_far.write_csv(target / TRIALS)

    with interruptible(), tuned(asked, means, folder, keep) as found, _results(folder, "tune") as target:
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
    means = _means(fmus, jobs, scheduler, exact)
    with interruptible(), swept(asked, means, folder) as searched, _results(folder, "sweep") as target:
        searched.write(target / "sweep.parquet")
        if report:
            from warmlink.orchestration.report.studies import write_sweep

            write_sweep(asked, searched.found, target / "report.html")
    _answer(searched, f"table   {folder / 'sweep.parquet'}", folder, report, json)


def _means(fmus: str | None, jobs: int, scheduler: str | None, exact: bool) -> Means:
    from warmlink.orchestration.fmu_store import kind_named
    from warmlink.orchestration.studies.at_work import Means

    return Means(kind_named(fmus), jobs, scheduler, exact)


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
def _results(folder: Path, command: str) -> Iterator[Path]:
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

"""`warmlink simulate`: run a system of FMUs from any tool."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line import arguments
from warmlink.orchestration.command_line.simulated import answer_run
from warmlink.orchestration.console import remark
from warmlink.orchestration.files import locked_folder, temporary_folder, write_files
from warmlink.orchestration.master.algorithms import DEFAULT_MASTER, ERROR_CONTROLLED
from warmlink.orchestration.progress import progress_bar
from warmlink.orchestration.results import refuse_others, results_folder, results_in

if TYPE_CHECKING:
    from warmlink.orchestration.master.algorithms.algorithm import Algorithm
    from warmlink.orchestration.master.error_budget import Attempt
    from warmlink.orchestration.master.guard import Line
    from warmlink.orchestration.master.recording.checkpoint import LongRun
    from warmlink.orchestration.master.recording.result import Result
    from warmlink.orchestration.master.slaves.isolation import Isolation
    from warmlink.orchestration.system.model import System

COMMANDS = ("simulate",)

DEFAULT_CHECKPOINT = 3600


def simulate(
    system: Path,
    *,
    variant: str | None = None,
    set_: list[str] | None = None,
    parameters: list[Path] | None = None,
    stop: str | None = None,
    step: str | None = None,
    master: str = DEFAULT_MASTER,
    stepping: str = "auto",
    out: Path | None = None,
    isolate: bool = False,
    time_limit: str | None = None,
    memory_limit: str | None = None,
    checkpoint: int | None = None,
    resume: bool = False,
    real_time: float | None = None,
    error_budget: bool | None = None,
    tolerance: str | None = None,
    fmu_tolerance: str | None = None,
    replace: list[str] | None = None,
    map_: list[str] | None = None,
    watch: list[str] | None = None,
    statistics: bool = False,
    record: str | None = None,
    csv: bool = True,
    quiet: bool = False,
    json: bool = False,
) -> None:
    """Run a system of FMUs, or a single FMU, and write its outputs as CSV and Parquet.

    If you press Ctrl-C, the process is told to end (SIGTERM), or an FMU fails, the run ends early and keeps
    what was computed up to there (exit code 1).

    Parameters
    ----------
    system : An .fmu or .ssp file from any tool.
    set_ : Change a start value, for example --set "link.length=400 mm", or as a number in the variable's own
        unit. Repeatable.
    parameters : A parameter set (SSV) with full names, or a single FMU's own. Repeatable.
    stop : Stop time, such as "1 h". Default: the one that the system proposes.
    step : Communication step size, such as "1 s". Default: the one that the system proposes.
    stepping : How the loop over the steps runs: `plain` (Python), `compiled` (C), or `auto`, which takes the
        faster one.
    out : Folder for results. Default: out/SYSTEM/simulate.
    isolate : Run each FMU in a process of its own, so that a crash of an FMU does not end this program.
    time_limit : Longest time that a call of an isolated FMU may take. Default: "60 s".
    memory_limit : Most memory that an isolated FMU may use. Default: "4 GB".
    checkpoint : Write the results to disk during the run, and a checkpoint every so many communication steps.
    resume : Continue from the checkpoint in the results folder, if there is one.
    real_time : Keep pace with the clock: 1 is real time, 10 is ten times as fast.
    error_budget : Bound the coupling error by repeating the run with half the communication step. Default:
        yes, unless --checkpoint, --resume or --real-time is given.
    fmu_tolerance : Relative tolerance of the solvers inside the FMUs, such as 1e-6. Default: that which each
        FMU proposes.
    watch : Variables whose coupling error is to be bounded, separated by commas. Repeatable. Default:
        every output.
    quiet : Print no table.
    """
    from warmlink.orchestration.master.algorithms.named import algorithm
    from warmlink.orchestration.master.compiled.loop import stepping_named
    from warmlink.orchestration.master.error_budget import Attempt, attempted
    from warmlink.orchestration.master.guard import guarded
    from warmlink.orchestration.master.recording.checkpoint import LongRun
    from warmlink.orchestration.master.recording.recorder import is_recorded
    from warmlink.orchestration.master.run import simulate as simulate_system
    from warmlink.orchestration.report.plot import refuse_unmatched
    from warmlink.orchestration.scenarios.plausible import declared_in, within_bands
    from warmlink.orchestration.scenarios.system_values import full_name, with_parameters
    from warmlink.orchestration.simulation import halvable, in_turns, relative_tolerance, variables
    from warmlink.orchestration.system.assemble import read_system
    from warmlink.orchestration.system.replacement import Replacements

    watch = arguments.listed(",".join(watch or ())) or None
    chosen, folder = algorithm(master), out or Path("out") / system.stem / "simulate"
    refuse_others(folder, "simulate")
    long_run = _long_run(folder, checkpoint, resume)
    # By default a run that keeps pace with the clock, or that may last for days, is not repeated.
    repeats = error_budget if error_budget is not None else real_time is None and long_run is None
    if tolerance is not None and not repeats:
        raise InputError(
            "--tolerance: needs a second run; leave out --no-error-budget, --checkpoint, --resume and "
            "--real-time"
        )
    with temporary_folder() as work, locked_folder(folder):
        read = Replacements.given(replace, map_).in_system(read_system(system, work, variant))
        for path in parameters or ():
            read = with_parameters(read, path)
        read = with_parameters(read, arguments.settings_given(set_))
        watch = [full_name(read, name) for name in watch] if watch else None
        for told in read.remarks:
            remark(told)
        stop_time, step_size, allowed = _experiment(read, stop, step, tolerance, watch)
        if repeats and not halvable(read, step_size):
            repeats = False
            remark(f"the coupling error is not bounded, for an FMU does not go on by {step_size / 2:g} s")
        outputs = [name for name, variable in variables(read).items() if is_recorded(variable)]
        written = [full_name(read, pattern) for pattern in arguments.listed(record) or ()]
        kept = [*outputs, *watch] if watch else None
        refuse_unmatched(written, kept or outputs)
        once = partial(
            simulate_system,
            read,
            stop_time,
            start_time=read.default_experiment.start_time,
            fmu_tolerance=relative_tolerance(fmu_tolerance),
            isolation=_isolation(isolate, time_limit, memory_limit),
            stepping=stepping_named(stepping),
            unpacked=work,
        )
        # The results of a run that writes checkpoints may not fit into memory.
        streamed = None if long_run is None else LongRun(work / "half", every=None)
        half = partial(once, step_size=step_size / 2, record=watch, long_run=streamed, check_stability=False)

        whole = partial(once, step_size=step_size, record=kept, pacing=real_time, statistics=statistics)

        def attempt(algorithm: Algorithm, line: Line | None) -> Result:
            stored = long_run
            if stored is not None and algorithm is not chosen:
                # A later attempt begins anew, and leaves no checkpoint, which the first one would take.
                stored = LongRun(stored.folder, every=None)
            return whole(algorithm=algorithm, long_run=stored, line=line)

        with results_folder(folder, "simulate") as target, progress_bar(read.name) as progress:
            if repeats:
                found = attempted(chosen, allowed, watch, in_turns(attempt, half, progress, remark))
            else:
                alone = guarded(partial(attempt, chosen), lambda done, count: progress(done / count), remark)
                found = Attempt(chosen, alone)
            known = declared_in(read)
            found = found.looked_at(lambda result: within_bands(result, known))
            found = found.with_remarks(*_beyond(found), *_late(read, found.unseen))
            lost = _write(found.result, target, folder, written, csv)
    by = master if found.algorithm is chosen else ERROR_CONTROLLED
    answer_run(found, folder, f"{read.name} · {step_size:g} s steps · {by}", watch, statistics, quiet, json)
    arguments.finish(folder, lost, found.stopped)


def _experiment(
    system: System, stop: str | None, step: str | None, tolerance: str | None, watch: Sequence[str] | None
) -> tuple[float, float, dict[str, float]]:
    """Stop time and communication step in s, and the coupling error that is allowed by variable."""
    from warmlink.orchestration import simulation

    stop_time, step_size = simulation.experiment_of(system, stop, step)
    allowed: dict[str, float] = {}
    if tolerance is not None:
        allowed = simulation.tolerances_of(system, tolerance, watch)
        asked = step_size if step or simulation.own_steps(system) else None
        step_size = simulation.largest_step(system, stop_time, asked)
    for told in simulation.remarks_on_steps(system, stop_time, step_size, stop):
        remark(told)
    return stop_time, step_size, allowed


def _write(result: Result, target: Path, folder: Path, written: Sequence[str], csv: bool) -> str | None:
    """Write the recorded values; what could not be written in the place of earlier ones is said."""
    from warmlink.orchestration.master.slaves.under_way import interruption
    from warmlink.orchestration.report.plot import series_writers

    with interruption():  # a Ctrl-C now does not cost what was computed
        earlier = bool(results_in(folder, "simulate"))
        return write_files(target, series_writers(result.table, written, csv), earlier)


def _beyond(found: Attempt) -> list[str]:
    """Say which variables are not within their tolerances."""
    told = "the coupling error is not within the tolerance; allow more, or give a smaller --step"
    return [f"{name}: {told}" for name in found.missed] if found.broken is None else []


def _long_run(folder: Path, checkpoint: int | None, resume: bool) -> LongRun | None:
    """How the run is written to disk; None where it is not, since neither is asked for."""
    from warmlink.orchestration.master.recording.checkpoint import LongRun

    if checkpoint is None and not resume:
        return None
    every = DEFAULT_CHECKPOINT if checkpoint is None else checkpoint
    return LongRun(folder.absolute(), every, resume)  # absolute, for an FMU may change the folder


def _late(system: System, unseen: Sequence[str]) -> list[str]:
    """Name components whose delay the error estimate does not see, without those that declare sampling."""
    from warmlink.orchestration.system.description import read_description

    fed = dict.fromkeys(link.target_component for link in system.connections)
    late = [name for name in fed if any(each.startswith(f"{name}.") for each in unseen)]
    told = (
        "follows steps of an FMU's own that are at least as long as those of the run, so that a second run "
        "does not show how late it is; take longer steps to bound its coupling error"
    )
    variables = {name: read_description(system.components[name].fmu).variables for name in late}
    return [f"{name}: {told}" for name, known in variables.items() if "sample_time" not in known]


def _isolation(isolate: bool, time_limit: str | None, memory_limit: str | None) -> Isolation | None:
    """Limits of each FMU's own process; None without --isolate."""
    from warmlink.orchestration.master.slaves.isolation import Isolation
    from warmlink.orchestration.written.quantities import positive

    limits = {}
    for name, text, unit in (("time", time_limit, "s"), ("memory", memory_limit, "B")):
        if text is not None and not isolate:
            raise InputError(f"--{name}-limit: applies only to FMUs in processes of their own; add --isolate")
        if text is not None:
            limits[f"{name}_limit"] = positive(text, unit, f"--{name}-limit")
    return Isolation(**limits) if isolate else None

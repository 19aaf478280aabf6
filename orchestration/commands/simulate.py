"""`warmlink simulate`: anybody's system of FMUs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.commands.console import progress_bar, remark
from warmlink.orchestration.commands.simulate_answer import give_answer
from warmlink.orchestration.files import fresh_folder, locked_folder, temporary_folder, write_files
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.table import algorithm
from warmlink.orchestration.master.compiled.loop import Stepping
from warmlink.orchestration.master.error_budget import CouplingError, estimate_coupling_error
from warmlink.orchestration.master.guard import guarded
from warmlink.orchestration.master.pacing import Pacing
from warmlink.orchestration.master.recording.checkpoint import LongRun
from warmlink.orchestration.master.recording.recorder import is_recorded
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import Progress, simulate
from warmlink.orchestration.master.slaves.isolation import Isolation
from warmlink.orchestration.report.series import series_writers
from warmlink.orchestration.scenarios.quantity import positive
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import DefaultExperiment, System
from warmlink.orchestration.system.read import read_system

STOPPED_EARLY = 1
DEFAULT_STEPS = 500
DEFAULT_CHECKPOINT = 3600


@dataclass(frozen=True)
class SimulateOptions:
    """What the command line says; times as written, as `"1 h"`.

    Attributes
    ----------
    system : the .ssp file
    stop, step : None for what the system proposes
    master, stepping : names
    out : folder for results; None for one under `out`
    time_limit, memory_limit : for one call of an isolated FMU, and for its process
    checkpoint : communication steps between checkpoints; None for a run kept in memory
    real_time : simulated seconds a second of wall time; None for as fast as it goes
    error_budget : whether to repeat the run with half the step; None where that costs no more than time
    watch : variables to be bounded and, if they are no outputs, recorded; all outputs where none are given
    """

    system: Path
    stop: str | None = None
    step: str | None = None
    master: str = "jacobi"
    stepping: str = "auto"
    out: Path | None = None
    isolate: bool = False
    time_limit: str | None = None
    memory_limit: str | None = None
    checkpoint: int | None = None
    resume: bool = False
    real_time: float | None = None
    error_budget: bool | None = None
    watch: tuple[str, ...] = ()

    @property
    def folder(self) -> Path:
        """Where results go."""
        return self.out or Path("out") / self.system.stem

    @property
    def isolation(self) -> Isolation | None:
        """One process for each FMU, where asked for."""
        for option, given in (("--time-limit", self.time_limit), ("--memory-limit", self.memory_limit)):
            if given is not None and not self.isolate:
                raise InputError(f"{option}: holds for FMUs in processes of their own; add --isolate")
        if not self.isolate:
            return None
        usual = Isolation()
        seconds, size = self.time_limit, self.memory_limit
        return Isolation(
            usual.time_limit if seconds is None else positive(seconds, "s", "--time-limit"),
            usual.memory_limit if size is None else positive(size, "B", "--memory-limit"),
        )

    @property
    def pacing(self) -> Pacing | None:
        """Clock to keep to, where asked for."""
        if self.real_time is None:
            return None
        if not 0 < self.real_time < float("inf"):
            raise InputError(
                f"--real-time {self.real_time:g}: no pace; give a number above 0, 1 for real time"
            )
        return Pacing(self.real_time)

    @property
    def long_run(self) -> LongRun | None:
        """Streams and checkpoints, where asked for."""
        if self.checkpoint is None and not self.resume:
            return None
        every = DEFAULT_CHECKPOINT if self.checkpoint is None else self.checkpoint
        # Absolute, for an FMU may change the folder.
        return LongRun(self.folder.absolute(), every, self.resume)

    @property
    def loop(self) -> Stepping:
        """How to step."""
        kinds: tuple[Stepping, ...] = get_args(Stepping)
        for known in kinds:
            if self.stepping == known:
                return known
        raise InputError(f"--stepping {self.stepping}: not known; {instead(self.stepping, kinds)}")

    @property
    def bounds_coupling(self) -> bool:
        """Whether to repeat the run: unasked, neither in real time nor where it may last for days."""
        if self.error_budget is not None:
            return self.error_budget
        return self.real_time is None and self.long_run is None


def simulate_command(options: SimulateOptions, as_json: bool) -> int:
    """Run, write and answer; gives the exit code."""
    chosen = algorithm(options.master)
    with temporary_folder() as work, locked_folder(options.folder):
        system = read_system(options.system, work)
        for told in system.remarks:
            remark(told)
        times = _experiment(system.default_experiment, options)
        runs = _Runs(system, chosen, options, times, work)
        with fresh_folder(options.folder) as target, progress_bar(system.name) as progress:
            result = runs.first(lambda done, count: progress(done / count / (1 + 2 * runs.repeats)))
            lost = write_files(target, series_writers(result))
            bounds = runs.bounds(result, lambda done, count: progress((1 + 2 * done / count) / 3))
    head = f"{system.name} · {times.step_size:g} s steps · {options.master}"
    give_answer(result, bounds, head, options.folder, as_json=as_json)
    for told in result.remarks:
        remark(told)
    if lost is not None:
        remark(f"{options.folder}: {lost}")
    if result.reason is not None:
        remark(f"stopped early: {result.reason}; what was computed up to there is kept")
    return 0 if lost is None and result.reason is None else STOPPED_EARLY


@dataclass(frozen=True)
class _Times:
    """Start, stop and step in s."""

    start: float
    stop: float
    step_size: float


@dataclass(frozen=True)
class _Runs:
    """The run that was asked for, and the one with half its step."""

    system: System
    algorithm: Algorithm
    options: SimulateOptions
    times: _Times
    work: Path

    @property
    def repeats(self) -> bool:
        return self.options.bounds_coupling

    def first(self, progress: Progress) -> Result:
        """Do what was asked for."""
        options, times, record = self.options, self.times, self._recorded()
        return guarded(
            lambda line: simulate(
                self.system,
                times.stop,
                times.step_size,
                self.algorithm,
                start_time=times.start,
                record=record,
                isolation=options.isolation,
                unpacked=self.work,
                stepping=options.loop,
                long_run=options.long_run,
                pacing=options.pacing,
                line=line,
            ),
            progress,
            remark,
        )

    def bounds(self, result: Result, progress: Progress) -> tuple[CouplingError, ...]:
        """Bound the coupling error of the watched variables; nothing where the run stopped early."""
        if not self.repeats or result.status != "completed":
            return ()
        names = self.options.watch or result.table.names

        def again(stop: float, step_size: float) -> Result:
            options = self.options
            # Values of a run that is streamed may not fit into the memory.
            streamed = None if options.long_run is None else LongRun(self.work / "half", every=None)
            return guarded(
                lambda line: simulate(
                    self.system,
                    stop,
                    step_size,
                    self.algorithm,
                    start_time=self.times.start,
                    record=names,
                    isolation=options.isolation,
                    unpacked=self.work,
                    stepping=options.loop,
                    long_run=streamed,
                    check_stability=False,
                    line=line,
                ),
                progress,
                remark,
            )

        return estimate_coupling_error(again, result, self.times.step_size, self.algorithm.order, names)

    def _recorded(self) -> tuple[str, ...] | None:
        if not self.options.watch:
            return None
        outputs = [
            f"{name}.{variable.name}"
            for name, component in self.system.components.items()
            for variable in read_description(component.fmu).variables.values()
            if is_recorded(variable)
        ]
        return (*outputs, *self.options.watch)


def _experiment(proposed: DefaultExperiment, options: SimulateOptions) -> _Times:
    stop = proposed.stop_time if options.stop is None else positive(options.stop, "s", "--stop")
    if stop is None:
        raise InputError(f'{options.system}: the system proposes no stop time; give one, as --stop "1 h"')
    step = proposed.step_size if options.step is None else positive(options.step, "s", "--step")
    return _Times(proposed.start_time, stop, step or stop / DEFAULT_STEPS)

"""A whole run of a system: from the files to the recorded values."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import cast, get_args

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.explicit import Jacobi
from warmlink.orchestration.master.algorithms.parts import REPEATABLE, InParts, Retry
from warmlink.orchestration.master.assembly import Assembly, assemble
from warmlink.orchestration.master.communication import CommunicationPoints, StepClock
from warmlink.orchestration.master.compiled.loop import Stepping, choose, obstacle
from warmlink.orchestration.master.guard import Line, Progress
from warmlink.orchestration.master.one_run import OneRun
from warmlink.orchestration.master.recording.checkpoint import Checkpoints, LongRun, fingerprint
from warmlink.orchestration.master.recording.recorder import Recorder, is_recorded
from warmlink.orchestration.master.recording.result import Balance, Result, heat_balances
from warmlink.orchestration.master.slaves.isolation import Isolation
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.master.slaves.slave import RunSpan, Slave, TimedSlave
from warmlink.orchestration.system.model import System

SAME = 1e-9
"""Relative and absolute difference by which two runs that should be the same may differ."""


def simulate(
    system: System | Assembly,
    stop_time: float,
    step_size: float | Sequence[float] | Array,
    algorithm: Algorithm | None = None,
    *,
    start_time: float = 0.0,
    record: Sequence[str] | None = None,
    balances: Sequence[Balance] | None = None,
    isolation: Isolation | None = None,
    unpacked: Path | None = None,
    stepping: Stepping = "auto",
    long_run: LongRun | None = None,
    pacing: float | None = None,
    check_stability: bool = True,
    statistics: bool = False,
    fmu_tolerance: float | None = None,
    progress: Progress | None = None,
    line: Line | None = None,
) -> Result:
    """Run a system from start to stop time; InputError where what was asked for cannot be run.

    The result is `stopped` where a slave failed or Ctrl-C was pressed, and `ended` where a slave asked to end
    the simulation; the values up to there are kept.

    Parameters
    ----------
    system : an assembly is closed at the end, also where it cannot be run
    stop_time, step_size, start_time : in s; the step must divide the time between start and stop. Times of
        all points from start to stop, in place of a step, lay out steps that differ
    algorithm : default: Jacobi. If a slave discards a step, the run of a system is begun anew by `Retry`,
        which repeats such steps in smaller parts; an assembly is run so from the start
    record : variables as `slave.variable`; default: every output
    balances : default: every heat balance found in the system; both ends are recorded
    isolation : one process for each FMU: a crash or an endless step then ends the run, not the program
    unpacked : folder that keeps the unpacked FMUs from run to run, for studies
    stepping : `plain`, `compiled`, `preferred`: compiled if that is possible, or `auto`: if it is faster,
        too. The values are the same
    long_run : write the values to disk during the run, write checkpoints, resume
    pacing : simulated seconds for each second of wall time; 1 is real time
    check_stability : after a run by Jacobi or Gauss-Seidel, unless it was paced, go back to its beginning and
        check whether a small disturbance grows; the slaves must restore their states. All values are
        recorded by then, so that slaves may be told before that nobody goes back in the run
    fmu_tolerance : relative tolerance of the solvers inside the FMUs; default: that which each FMU proposes
    statistics : count and time the calls of every slave, which plain stepping makes
    progress : called with communication steps done and to do, about 200 times in a run
    line : to the process that guards this one: gets the result before the slaves are ended and freed
    """
    try:
        points = _laid_out(start_time, stop_time, step_size)
        stepping = _stepping(stepping, isolation is not None or pacing is not None or statistics, pacing)
    except InputError:
        if isinstance(system, Assembly):
            system.close()
        raise
    algorithm = algorithm or Jacobi()
    request = RunRequest(
        points, record, balances, stepping, pacing, check_stability, fmu_tolerance, progress, line
    )

    def attempt(by: InParts, long_run: LongRun | None = long_run) -> tuple[Result, bool]:
        made = assemble(system, isolation, unpacked) if isinstance(system, System) else system
        if statistics:
            made = replace(made, slaves=[cast(Slave, TimedSlave(each)) for each in made.slaves])
        return request.carried_out(made, by, long_run)

    if isinstance(algorithm, InParts) or not isinstance(system, System):
        return attempt(algorithm if isinstance(algorithm, InParts) else Retry(algorithm))[0]
    # Slaves are told the truth: no state is copied, to go back to, before a step is discarded.
    once, begins_anew = attempt(Retry(algorithm, back=False))
    if not begins_anew:
        return once
    last = {
        name: once.table[name][-1:].tolist() for name in once.table.names
    }  # the next run takes the memory
    # A checkpoint of the run that ended is one of this run, too.
    again, _ = attempt(Retry(algorithm), long_run and replace(long_run, resume=True))
    return replace(again, remarks=(*again.remarks, *differing(len(once.table) - 1, last, again)))


def _laid_out(
    start_time: float, stop_time: float, step_size: float | Sequence[float] | Array
) -> CommunicationPoints:
    if isinstance(step_size, Sequence | np.ndarray):
        return CommunicationPoints.at([float(each) for each in step_size], start_time, stop_time)
    return CommunicationPoints.between(start_time, stop_time, step_size)


def _stepping(stepping: Stepping, watched: bool, pacing: float | None) -> Stepping:
    """How a run steps that is `watched` at every step, or not; InputError where it cannot be as asked."""
    if pacing is not None and not 0 < pacing < math.inf:
        raise InputError(f"{argument('pacing', pacing)}: not a pace; give a number above 0 (1 is real time)")
    if stepping not in get_args(Stepping):
        told = instead(stepping, get_args(Stepping))
        raise InputError(f"{argument('stepping', stepping)}: not known; {told}")
    if watched and stepping == "compiled":
        raise InputError(
            "compiled stepping: goes neither with isolated slaves nor with a pace or statistics; "
            "leave one out"
        )
    return "plain" if watched else stepping


def differing(row: int, values: Mapping[str, list[float]], again: Result) -> tuple[str, ...]:
    """Say what differs from an earlier run at the one row whose values are known."""
    if not 0 <= row < len(again.table):
        return ()
    for name, (before,) in values.items():
        now = again.table[name][row].item()
        if before == before and not math.isclose(before, now, rel_tol=SAME, abs_tol=SAME):
            return (
                f"{name} is {before:g} at {again.times[row]:g} s in a run that never repeats a step, and "
                f"{now:g} in this one, which may: an FMU behaves in another way where it is told so",
            )
    return ()


@dataclass(frozen=True)
class RunRequest:
    """What is asked of a run, as `simulate` has it."""

    points: CommunicationPoints
    record: Sequence[str] | None
    balances: Sequence[Balance] | None
    stepping: Stepping
    pacing: float | None
    check_stability: bool
    tolerance: float | None
    progress: Progress | None
    line: Line | None
    process: int = field(default_factory=os.getpid)

    def carried_out(
        self, assembly: Assembly, algorithm: InParts, long_run: LongRun | None
    ) -> tuple[Result, bool]:
        """Run an assembly, which is closed at the end.

        Tells, too, whether the run is to be begun anew with an algorithm that goes back.
        """
        try:
            balances = self.balances
            if balances is None:
                balances = heat_balances(assembly.slaves, assembly.connections)
            run = self._prepared(assembly, algorithm, long_run, balances)
            network, about = run.network, tuple(balances)

            def keep(found: Result, over: bool = False) -> None:
                network.end_copies()
                if self.line is not None:
                    self.line.keep(replace(found, balances=about), over)

            found = run.run(keep, self.check_stability and self.pacing is None)
            result = replace(found, balances=about)
            network.end_copies()
            error, able = result.error, not (network.unable_to_restore() or network.of_one_step())
            anew = error and error.status in REPEATABLE and able and not algorithm.goes_back
            if error and anew and self.pacing is not None:
                error, anew = error.because("no smaller step was tried, for the run keeps pace"), False
                result = replace(result, reason=str(error), error=error)
            # FMUs in processes of their own harm nothing here when they end, and may take their time for it.
            alone = any(getattr(slave, "isolation", None) for slave in assembly.slaves)
            if not anew:
                keep(result, over=not alone)
            network.release()
            if alone and not anew:
                assembly.close()
                ended = (told for slave in network.slaves for told in slave.remarks)
                new = tuple(told for told in ended if told not in result.remarks)
                result = replace(result, remarks=(*result.remarks, *new))
                keep(result, over=True)
            return result, bool(anew)
        finally:
            assembly.close()

    def _prepared(
        self, assembly: Assembly, algorithm: InParts, long_run: LongRun | None, balances: Sequence[Balance]
    ) -> OneRun:
        """A run that is ready to begin; InputError where it cannot be as it was asked for."""
        points, line, progress = self.points, self.line, self.progress
        known = [(slave.name, v) for slave in assembly.slaves for v in slave.variables.values()]
        outputs = [f"{slave}.{v.name}" for slave, v in known if is_recorded(v)]
        ends = [end for balance in balances for end in (balance.delivered, balance.received)]
        names = list(dict.fromkeys([*(outputs if self.record is None else self.record), *ends]))
        watched = sorted(set(names) & set(outputs))
        network = Network(assembly.slaves, assembly.connections, watched, self.process)
        schedule = algorithm.schedule(network)
        chosen = algorithm.inner if isinstance(algorithm, Retry) else algorithm
        compiled = choose(self.stepping, chosen, schedule, points.count * len(assembly.slaves))
        stepper = algorithm.bind(network, points)
        # Whatever is wrong with the checkpoint shows before anything in the folder is touched.
        checkpoints, values = None, None
        if long_run is not None:
            said = fingerprint(assembly, names, points, algorithm, self.tolerance)
            checkpoints = Checkpoints(long_run, network, said)
            values = checkpoints.values
        recorder = Recorder(network, names, points, values, None if line is None else line.block)
        if line is not None:
            file = None if values is None else values.path
            line.began(Result(recorder.header, "stopped", balances=tuple(balances)), file)
            progress = line.progress
        if checkpoints is not None and checkpoints.found is None:
            checkpoints.forget()
        hindrance = obstacle(network, recorder) if compiled else None
        if hindrance is not None and self.stepping == "compiled":
            raise InputError(f"compiled stepping: {hindrance}; choose plain stepping")
        clock = None if self.pacing is None else StepClock(self.pacing)
        compiled = compiled and hindrance is None
        return OneRun(
            *(assembly, network, recorder, stepper, schedule, checkpoints, clock, progress, compiled),
            RunSpan(points.start_time, points.stop_time, self.tolerance, algorithm.goes_back),
        )

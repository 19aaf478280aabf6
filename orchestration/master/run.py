"""A whole run of a system: from the files to the recorded values."""

from __future__ import annotations

import math
import os
import sys
import time
from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, cast

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Schedule, Stepper
from warmlink.orchestration.master.algorithms.explicit import Jacobi
from warmlink.orchestration.master.algorithms.parts import InParts, Retry
from warmlink.orchestration.master.assembly import Assembly, assemble, initialize
from warmlink.orchestration.master.communication import Clock, CommunicationPoints
from warmlink.orchestration.master.compiled.loop import CompiledLoop, Stepping, choose, obstacle
from warmlink.orchestration.master.error_budget import instability
from warmlink.orchestration.master.guard import Line, Progress
from warmlink.orchestration.master.recording.checkpoint import Checkpoints, LongRun, fingerprint
from warmlink.orchestration.master.recording.recorder import Recorder, StoreError, is_recorded
from warmlink.orchestration.master.recording.result import Balance, Result, Statistics, heat_balances
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.fmi import FmiSlave
from warmlink.orchestration.master.slaves.isolation import Isolation
from warmlink.orchestration.master.slaves.network import Network, Snapshot
from warmlink.orchestration.master.slaves.slave import Slave, SlaveError, TimedSlave
from warmlink.orchestration.master.slaves.under_way import interruption
from warmlink.orchestration.system.model import System


def simulate(
    system: System | Assembly,
    stop_time: float,
    step_size: float | Sequence[float],
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
    progress: Progress | None = None,
    line: Line | None = None,
) -> Result:
    """Run a system from start to stop time; InputError where what was asked for cannot be run.

    The result is `stopped` where a slave failed or Ctrl-C was pressed; the values up to there are kept.

    Parameters
    ----------
    system : an assembly is closed at the end
    stop_time, step_size, start_time : in s; the step must divide the time between start and stop. Times of
        all points, in place of a step, lay out steps that differ
    algorithm : default: Jacobi. Steps that a slave discards are repeated in smaller parts, as `Retry` does it
    record : variables as `slave.variable`; default: every output
    balances : default: every heat balance found in the system; both ends are recorded
    isolation : one process for each FMU: a crash or an endless step then ends the run, not the program
    unpacked : folder that keeps the unpacked FMUs from run to run, for studies
    stepping : `plain`, `compiled`, `preferred`: compiled if that is possible, or `auto`: if it is faster,
        too. The values are the same
    long_run : write the values to disk during the run, write checkpoints, resume
    pacing : simulated seconds for each second of wall time; 1 is real time
    check_stability : after a run by Jacobi or Gauss-Seidel, unless it was paced, go back to its beginning and
        check whether a small disturbance grows; the slaves must restore their states
    statistics : count and time the calls of every slave, which plain stepping makes
    progress : called with communication steps done and to do, about 200 times in a run
    line : to the process that guards this one: gets the result before the slaves are ended and freed
    """
    process = os.getpid()
    if pacing is not None and not 0 < pacing < math.inf:
        raise InputError(f"--real-time {pacing:g}: not a pace; give a number above 0 (1 is real time)")
    if isinstance(step_size, Sequence):
        points = CommunicationPoints.at(step_size)
    else:
        points = CommunicationPoints.between(start_time, stop_time, step_size)
    algorithm = algorithm or Jacobi()
    retrying = algorithm if isinstance(algorithm, InParts) else Retry(algorithm)
    if isolation is not None or pacing is not None or statistics:
        if stepping == "compiled":
            raise InputError(
                "compiled stepping: goes neither with isolated slaves nor with a pace or statistics; "
                "leave one out"
            )
        stepping = "plain"
    assembly = assemble(system, isolation, unpacked) if isinstance(system, System) else system
    if statistics:
        assembly = replace(assembly, slaves=[cast(Slave, TimedSlave(each)) for each in assembly.slaves])
    try:
        if balances is None:
            balances = heat_balances(assembly.slaves, assembly.connections)
        known = [(slave.name, v) for slave in assembly.slaves for v in slave.variables.values()]
        outputs = [f"{slave}.{v.name}" for slave, v in known if is_recorded(v)]
        ends = [end for balance in balances for end in (balance.delivered, balance.received)]
        names = list(dict.fromkeys([*(outputs if record is None else record), *ends]))
        network = Network(assembly.slaves, assembly.connections, sorted(set(names) & set(outputs)), process)
        schedule = retrying.schedule(network)
        compiled = choose(stepping, algorithm, schedule, points.count * len(assembly.slaves))
        stepper = retrying.bind(network, points)
        # Whatever is wrong with the checkpoint shows before anything in the folder is touched.
        checkpoints, values = None, None
        if long_run is not None:
            checkpoints = Checkpoints(long_run, network, fingerprint(assembly, names, points, retrying))
            values = checkpoints.values
        recorder = Recorder(network, names, points, values, None if line is None else line.block)
        if line is not None:
            file = None if values is None else values.path
            line.began(Result(recorder.header, "stopped", balances=tuple(balances)), file)
            progress = line.progress
        if checkpoints is not None and checkpoints.found is None:
            checkpoints.forget()
        hindrance = obstacle(network, recorder) if compiled else None
        if hindrance is not None and stepping == "compiled":
            raise InputError(f"compiled stepping: {hindrance}; choose plain stepping")
        clock = None if pacing is None else Clock(pacing)
        compiled = compiled and hindrance is None
        run = Run(assembly, network, recorder, stepper, schedule, checkpoints, clock, progress, compiled)

        def keep(found: Result, over: bool) -> Result:
            kept = replace(found, balances=tuple(balances))
            network.end_copies()
            if line is not None:
                line.keep(kept, over)
            return kept

        found = run.result(lambda found: keep(found, False), check_stability and pacing is None)
        # Isolated FMUs cannot harm this process when they end, and may take the time that they have for it.
        result = keep(found, isolation is None)
        network.release()
        assembly.close()
        ended = (told for slave in network.slaves for told in slave.remarks)
        new = tuple(told for told in ended if told not in result.remarks)
        return keep(replace(result, remarks=(*result.remarks, *new)), True) if isolation or new else result
    finally:
        assembly.close()


@dataclass
class Run:
    """One run: initialize, step to the end or to a failure, and say what was recorded.

    The compiled loop steps, where it can, from the second step on.
    """

    assembly: Assembly
    network: Network
    recorder: Recorder
    stepper: Stepper
    schedule: Schedule | None
    checkpoints: Checkpoints | None
    clock: Clock | None
    progress: Progress | None
    compiled: bool
    _loop: CompiledLoop | None = None

    def result(self, keep: Callable[[Result], object], check_stability: bool) -> Result:
        """Do the run and say how it went; before its stability is checked, its result is kept."""
        recorder, network, stepper, schedule = self.recorder, self.network, self.stepper, self.schedule
        fault: SlaveError | None = None
        reason: str | None = None
        start, began = None, time.perf_counter()
        try:
            with interruption():
                initialize(network, recorder.points, self.assembly.values)
                if self.checkpoints is None or self.checkpoints.found is None:
                    recorder.take()
                else:
                    self.checkpoints.restore(recorder, stepper)
                if check_stability and schedule is not None and not network.unable_to_restore():
                    start = network.snapshot(), stepper.memory()
                began = time.perf_counter()
                if not self._step_through():
                    raise KeyboardInterrupt
        except SlaveError as error:
            fault, reason = error, str(error)
        except StoreError as error:
            reason = str(error)
        except KeyboardInterrupt:
            reason = f"interrupted at {recorder.points.time(max(recorder.rows - 1, 0)):g} s"
        timed = [each.statistics for each in network.slaves if isinstance(each, TimedSlave)]
        resumed = self.checkpoints and self.checkpoints.found
        statistics = Statistics(
            communication_steps=max(recorder.rows - 1, 0),
            resumed_steps=resumed.rows - 1 if resumed else 0,
            slave_steps=network.steps,
            rejected_steps=network.rejected.total(),
            limits_the_step=next((name for name, _ in network.rejected.most_common(1)), None),
            initialization_sweeps=network.sweeps,
            wall_seconds=time.perf_counter() - began,
            compiled=self.compiled,
            largest_lag=0.0 if self.clock is None else self.clock.lag,
            slaves=tuple(deepcopy(timed)),
            memory_bytes=_memory(),
        )
        status: Literal["completed", "stopped"] = "completed" if reason is None else "stopped"
        done = Result(recorder.table(), status, reason, fault, statistics=statistics)

        def told(*more: str) -> Result:
            conduct = [told for slave in network.slaves for told in slave.remarks]
            return replace(done, remarks=(*conduct, *stepper.remarks, *more))

        if (
            start is None
            or schedule is None
            or not (reason is None or (fault and fault.status == "not finite"))
        ):
            return told()
        keep(told())
        return told(*self._stability(schedule, *start))

    def _stability(self, schedule: Schedule, first: Snapshot, memory: object) -> tuple[str, ...]:
        """Say whether the run was unstable, or why that cannot be said; `first` is its beginning."""

        def rewind() -> None:
            self.network.rewind(first)
            self.stepper.recall(memory)

        name = "Jacobi" if schedule.at_once else "GaussSeidel"
        try:
            return instability(name, self.network, self.recorder.points, rewind, self._fill)
        except SlaveError as failure:
            return (f"whether these steps are stable is not known: {failure}",)

    def _step_through(self) -> bool:
        """Step over all communication points that are not recorded yet; False where Ctrl-C came."""
        recorder, checkpoints, last = self.recorder, self.checkpoints, self.recorder.points.count
        stride, first = max(1, last // 200), recorder.rows
        while recorder.rows <= last:
            self.network.end_copies()
            if under_way.asked():
                return False
            if self.compiled and self._loop is None and recorder.rows > first:
                self._begin_loop(recorder)
            until = last if checkpoints is None else checkpoints.next_after(recorder.rows - 1, last)
            self._advance(recorder, until)
            point = recorder.rows - 1
            if self.clock is not None:
                self.clock.wait(recorder.points.time(point) - recorder.points.start_time)
            if checkpoints is not None and checkpoints.due(point):
                checkpoints.save(recorder, self.stepper)
            if self.progress is not None and (self._loop or point % stride == 0 or point == last):
                self.progress(point, last)
        return True

    def _advance(self, recorder: Recorder, until: int) -> None:
        """Step once, or with the compiled loop to a point at most; not at all where that gives up."""
        if self._loop is None:
            point, points = recorder.rows - 1, recorder.points
            self.stepper.step(points.time(point), points.step(point))
            recorder.take()
        elif not self._loop.advance(until):
            self._loop, self.compiled = None, False

    def _begin_loop(self, recorder: Recorder) -> None:
        """Go on with the compiled loop, unless the first step, a plain one, changed what FMUs share."""
        watched = (isinstance(slave, FmiSlave) and slave.watched for slave in self.network.slaves)
        self.compiled = self.compiled and not any(watched)
        if self.compiled and self.schedule is not None:
            # Copies of states that the stepper holds will be from long ago if it has to go on.
            self.stepper.recall(self.stepper.memory())
            self._loop = CompiledLoop(self.network, self.schedule, recorder)

    def _fill(self, recorder: Recorder) -> None:
        """Step until a recorder is full, once more after the run."""
        self._loop = None
        self._begin_loop(recorder)
        while recorder.rows <= recorder.points.count:
            self._advance(recorder, recorder.points.count)


def _memory() -> int:
    """Largest memory in bytes that this process has held; 0 where the platform does not tell."""
    if sys.platform == "win32":
        return 0
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)

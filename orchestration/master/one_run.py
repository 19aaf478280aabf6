"""One run of slaves: initialized, stepped to the end or to a failure."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass

from warmlink.orchestration.master.algorithms.algorithm import Schedule, Stepper
from warmlink.orchestration.master.assembly import Assembly, initialize
from warmlink.orchestration.master.communication import CommunicationPoints, StepClock
from warmlink.orchestration.master.compiled.loop import CompiledLoop
from warmlink.orchestration.master.error_budget import instability
from warmlink.orchestration.master.guard import Progress
from warmlink.orchestration.master.recording.checkpoint import Checkpoints
from warmlink.orchestration.master.recording.recorder import Recorder, StoreError
from warmlink.orchestration.master.recording.result import Result, Statistics
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.fmi import FmiSlave
from warmlink.orchestration.master.slaves.network import Network, SlaveStates
from warmlink.orchestration.master.slaves.slave import RunSpan, SlaveError, TimedSlave
from warmlink.orchestration.master.slaves.under_way import interruption


@dataclass
class OneRun:
    """One run: initialize, step to the end or to a failure, and say what was recorded.

    The compiled loop steps, where it can, from the second step on.
    """

    assembly: Assembly
    network: Network
    recorder: Recorder
    stepper: Stepper
    schedule: Schedule | None
    checkpoints: Checkpoints | None
    clock: StepClock | None
    progress: Progress | None
    compiled: bool
    experiment: RunSpan
    _loop: CompiledLoop | None = None

    def run(self, keep: Callable[[Result], None], check_stability: bool) -> Result:
        """Do the run and say how it went; a whole run's result is kept before its stability is checked."""
        recorder, network, stepper, schedule = self.recorder, self.network, self.stepper, self.schedule
        fault: SlaveError | None = None
        reason: str | None = None
        start, first, began = None, 0, time.perf_counter()
        try:
            with interruption():
                initialize(network, self.experiment, self.assembly.values)
                if self.checkpoints is None or self.checkpoints.found is None:
                    recorder.take()
                else:
                    self.checkpoints.restore(recorder, stepper)
                first = recorder.rows - 1
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
        ended, table = fault is not None and fault.status == "ended", recorder.table()

        def finished(*more: str) -> Result:
            conduct = [told for slave in network.slaves for told in slave.remarks]
            return Result(
                table,
                "completed" if reason is None else "ended" if ended else "stopped",
                reason,
                fault,
                remarks=(*conduct, *stepper.remarks, *more, *([reason] if ended and reason else [])),
                statistics=statistics,
            )

        if start and schedule and (reason is None or (fault and fault.status == "not finite")):
            if reason is None:
                keep(finished())
            return finished(*self._stability(schedule, recorder.points.following(first), *start))
        return finished()

    def _stability(
        self, schedule: Schedule, points: CommunicationPoints, states: SlaveStates, memory: object
    ) -> tuple[str, ...]:
        """Say whether the run was unstable, or why that is not known; the states are of the first point.

        That of a run that was resumed is the point from which it went on.
        """

        def rewind() -> None:
            self.network.rewind(states)
            self.stepper.recall(memory)

        name = "Jacobi" if schedule.at_once else "GaussSeidel"
        try:
            return instability(name, self.network, points, rewind, self._fill)
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
            end = self.network.end()
            if end is not None:
                raise end
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
            back = self.experiment.goes_back
            self._loop = CompiledLoop(self.network, self.schedule, recorder, goes_back=back)

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

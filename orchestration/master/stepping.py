"""A run in progress: initialize, step to the end or to a failure, and return what was recorded."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass

from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Stepper
from warmlink.orchestration.master.compiled.loop import CompiledLoop
from warmlink.orchestration.master.initialization import initialize
from warmlink.orchestration.master.pacing import Clock, interruption
from warmlink.orchestration.master.recording.audit import Balance
from warmlink.orchestration.master.recording.checkpoint import Checkpoints
from warmlink.orchestration.master.recording.recorder import Recorder
from warmlink.orchestration.master.recording.result import Result, Statistics
from warmlink.orchestration.master.recording.stores import StoreError
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.fmi import FmiSlave
from warmlink.orchestration.master.slaves.network import Network, Snapshot
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.master.slaves.timed import TimedSlave
from warmlink.orchestration.master.stability import GROWS_FROM, growth
from warmlink.orchestration.system.model import Value

Progress = Callable[[int, int], None]


@dataclass
class Run:
    """One run in progress.

    Attributes
    ----------
    algorithm : Algorithm
        Does the whole steps.
    values : mapping
        Start values by slave and variable, in the variables' own units.
    compiled : bool
        Whether the compiled loop steps, from the second step on.
    check_stability : bool
        Whether to check after the run if a small disturbance grows.
    """

    network: Network
    recorder: Recorder
    stepper: Stepper
    algorithm: Algorithm
    values: Mapping[str, Mapping[str, Value]]
    balances: tuple[Balance, ...]
    checkpoints: Checkpoints | None
    clock: Clock | None
    progress: Progress | None
    compiled: bool
    check_stability: bool
    _sweeps: int = 0
    _start: tuple[Snapshot, object] | None = None

    def result(self) -> Result:
        """Do the run and say how it went."""
        recorder, network = self.recorder, self.network
        failure: SlaveError | str | None = None
        began = time.perf_counter()
        try:
            with interruption():
                self._begin()
                began = time.perf_counter()
                if not self._step_through():
                    failure = self._interrupted()
        except SlaveError as error:
            failure = error
        except StoreError as error:
            failure = str(error)
        except KeyboardInterrupt:
            failure = self._interrupted()
        statistics = Statistics(
            communication_steps=max(recorder.rows - 1, 0),
            slave_steps=network.steps,
            rejected_steps=network.rejected,
            initialization_sweeps=self._sweeps,
            wall_seconds=time.perf_counter() - began,
            compiled=self.compiled,
            largest_lag=0.0 if self.clock is None else self.clock.lag,
            slaves=tuple(
                deepcopy(each.statistics) for each in network.slaves if isinstance(each, TimedSlave)
            ),
            memory_bytes=_memory(),
        )
        remarks = (*self.stepper.remarks, *self._stability(failure))
        conduct = tuple(told for slave in network.slaves for told in slave.remarks)
        return Result(
            recorder.table(),
            "completed" if failure is None else "stopped",
            None if failure is None else str(failure),
            failure if isinstance(failure, SlaveError) else None,
            self.balances,
            (*conduct, *remarks),
            statistics,
        )

    def _stability(self, failure: SlaveError | str | None) -> tuple[str, ...]:
        """Say when the explicit algorithm is unstable with this step."""
        diverged = isinstance(failure, SlaveError) and failure.status == "not finite"
        if self._start is None or not (failure is None or diverged):
            return ()
        points = self.recorder.points
        factor = growth(self.network, self.stepper, points, *self._start)
        if factor is None or factor < GROWS_FROM:
            return ()
        return (
            f"{type(self.algorithm).__name__} is unstable here with steps of {points.step_size:g} s: a "
            f"disturbance of the exchanged values grows {factor:.3g} times in a step; take smaller steps or "
            "an iterated algorithm",
        )

    def _interrupted(self) -> str:
        recorder = self.recorder
        return f"interrupted at {recorder.points.time(max(recorder.rows - 1, 0)):g} s"

    def _begin(self) -> None:
        """Initialize, or go on from a checkpoint."""
        self._sweeps = initialize(self.network, self.recorder.points, self.values)
        if self.checkpoints is None or self.checkpoints.found is None:
            self.recorder.take(0)
        else:
            self._sweeps = self.checkpoints.restore(self.checkpoints.found, self.recorder, self.stepper)
        if self.check_stability and not self.network.unable_to_restore():
            self._start = (self.network.snapshot(), self.stepper.memory())

    def _step_through(self) -> bool:
        """Step over all communication points that are not recorded yet; False where Ctrl-C came."""
        recorder, points, stepper = self.recorder, self.recorder.points, self.stepper
        stride, last = max(1, points.count // 200), points.count
        loop, first = None, recorder.rows
        while recorder.rows <= last:
            self.network.end_copies()
            if under_way.asked():
                return False
            if self.compiled and loop is None and recorder.rows > first:
                loop = self._loop()
            if loop is not None:
                done = recorder.rows - 1
                stop = last if self.checkpoints is None else self.checkpoints.next_after(done, last)
                if not loop.advance(stop):
                    loop, self.compiled = None, False
                    stepper.recall(stepper.memory())  # copies of states that it holds are from long ago
                    continue
            else:
                stepper.step(points.time(recorder.rows - 1), points.step(recorder.rows - 1))
                recorder.take(recorder.rows)
            point = recorder.rows - 1
            if self.clock is not None:
                self.clock.wait(points.time(point) - points.start_time)
            if self.checkpoints is not None and self.checkpoints.due(point):
                self.checkpoints.save(recorder, stepper, self._sweeps)
            if self.progress is not None and (loop is not None or point % stride == 0 or point == last):
                self.progress(point, last)
        return True

    def _loop(self) -> CompiledLoop | None:
        """Give the compiled loop, unless the first step, a plain one, changed what FMUs share."""
        if any(isinstance(slave, FmiSlave) and slave.watched for slave in self.network.slaves):
            self.compiled = False
            return None
        schedule = self.algorithm.schedule(self.network)
        return CompiledLoop(self.network, schedule, self.recorder, self.recorder.points)


def _memory() -> int:
    """Largest memory in bytes that this process has held; 0 where the platform does not tell."""
    try:
        import resource
    except ImportError:  # Windows
        return 0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)

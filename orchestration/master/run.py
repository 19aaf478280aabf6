"""A whole run: initialize, step to the end or to a failure, give back what was recorded."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithm import Algorithm, Stepper
from warmlink.orchestration.master.assembly import Assembly, assemble
from warmlink.orchestration.master.audit import Balance, audit, heat_balances
from warmlink.orchestration.master.checkpoint import Checkpoint, Checkpoints, LongRun, fingerprint
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.compiled import CompiledLoop, Stepping, choose, is_loaded
from warmlink.orchestration.master.fmi import FmiSlave
from warmlink.orchestration.master.gauss_seidel import GaussSeidel
from warmlink.orchestration.master.initialization import initialize
from warmlink.orchestration.master.jacobi import Jacobi
from warmlink.orchestration.master.layout import obstacle
from warmlink.orchestration.master.line import Line, Sketch
from warmlink.orchestration.master.network import Network, Snapshot
from warmlink.orchestration.master.pacing import Clock, Interruption, Pacing
from warmlink.orchestration.master.recorder import Recorder, outputs_of
from warmlink.orchestration.master.result import Result, Statistics
from warmlink.orchestration.master.retry import Retry
from warmlink.orchestration.master.slave import SlaveError
from warmlink.orchestration.master.stability import GROWS_FROM, growth
from warmlink.orchestration.master.step_doubling import StepDoubling
from warmlink.orchestration.master.stores import VALUES, Folder, Memory, Store, StoreError
from warmlink.orchestration.system.model import System

if TYPE_CHECKING:
    from warmlink.orchestration.master.isolation import Isolation

Progress = Callable[[int, int], None]


def simulate(
    system: System | Assembly,
    stop_time: float,
    step_size: float,
    algorithm: Algorithm | None = None,
    *,
    start_time: float = 0.0,
    record: Sequence[str] | None = None,
    balances: Sequence[Balance] | None = None,
    isolation: Isolation | None = None,
    unpacked: Path | None = None,
    stepping: Stepping = "auto",
    long_run: LongRun | None = None,
    pacing: Pacing | None = None,
    check_stability: bool = True,
    progress: Progress | None = None,
    line: Line | None = None,
) -> Result:
    """Run a system from start to stop time.

    Parameters
    ----------
    system : System or Assembly
        An assembly's slaves are terminated at the end.
    stop_time, step_size, start_time : float
        In s; the step must divide the time between start and stop.
    algorithm : Algorithm, optional
        Default: Jacobi. Steps that a slave discards are repeated in smaller parts, as `Retry` does by
        default; give a `Retry` to state the minimum.
    record : sequence of str, optional
        Variables as `slave.variable`; default: every output.
    balances : sequence of Balance, optional
        Default: every heat balance found in the system; both ends are recorded.
    isolation : Isolation, optional
        One process for each FMU: a crash or an endless step then ends the run, not the program.
    unpacked : Path, optional
        Folder that keeps the unpacked FMUs from run to run, for studies.
    stepping : str
        `plain`, `compiled`, or `auto`: compiled where that can be had and pays. The values are the same.
    long_run : LongRun, optional
        Stream the values to disk, leave checkpoints, resume.
    pacing : Pacing, optional
        Keep to the clock on the wall.
    check_stability : bool
        After a run by Jacobi or Gauss-Seidel of slaves that restore their states, go back to its beginning
        and look whether a small disturbance grows; not done in a paced run.
    progress : callable, optional
        Called with communication steps done and to do, about 200 times a run.
    line : Line, optional
        To the process that guards this one: gets the result before the slaves are ended and freed.

    Returns
    -------
    Result
        With status `stopped` where a slave failed or Ctrl-C was pressed; the values up to there are kept.

    Raises
    ------
    InputError
        Where what was asked for cannot be run.
    """
    process = os.getpid()
    points = CommunicationPoints.between(start_time, stop_time, step_size)
    algorithm = algorithm or Jacobi()
    if isolation is not None or pacing is not None:
        if stepping == "compiled":
            raise InputError(
                "compiled stepping: goes neither with isolated slaves nor with a pace; leave one out"
            )
        stepping = "plain"
    plain = algorithm.inner if isinstance(algorithm, Retry) else algorithm
    # The loop must be there before a library is loaded, so this comes first.
    compiled = isinstance(system, System) and choose(stepping, plain, points, len(system.components))
    assembly = assemble(system, isolation, unpacked) if isinstance(system, System) else system
    try:
        if isinstance(system, Assembly) and (stepping == "compiled" or is_loaded()):
            compiled = choose(stepping, plain, points, len(assembly.slaves))
        run = _prepare(assembly, points, algorithm, record, balances, long_run, line)
        run.network.process = process
        run.clock = None if pacing is None else Clock(pacing)
        run.progress = progress if line is None else line.progress
        run.check_stability = check_stability and pacing is None
        hindrance = obstacle(run.network, run.recorder) if compiled else None
        if hindrance is not None and stepping == "compiled":
            raise InputError(f"compiled stepping: {hindrance}; choose plain stepping")
        run.compiled = compiled and hindrance is None
        result = run.result(assembly)
        run.network.end_copies()
        if line is not None:
            line.keep(result)
        run.network.release()
        return result
    finally:
        for slave in assembly.slaves:
            # A slave that fails to end changes nothing about the run that lies behind.
            with contextlib.suppress(SlaveError):
                slave.terminate()
        assembly.close()


def _prepare(
    assembly: Assembly,
    points: CommunicationPoints,
    algorithm: Algorithm,
    record: Sequence[str] | None,
    balances: Sequence[Balance] | None,
    long_run: LongRun | None,
    line: Line | None,
) -> Run:
    outputs = outputs_of(assembly.slaves)
    names = list(outputs if record is None else record)
    if balances is None:
        balances = heat_balances(assembly.slaves, assembly.connections)
    for balance in balances:
        names += [balance.delivered, balance.received]
    network = Network(assembly.slaves, assembly.connections, sorted(set(names) & set(outputs)))
    if not isinstance(algorithm, Retry | StepDoubling):
        algorithm = Retry(algorithm)
    stepper = algorithm.bind(network, points)
    names = list(dict.fromkeys(names))
    checkpoints = found = None
    store: Store = Memory(line)
    if long_run is not None:
        # Whatever is wrong with the checkpoint shows before anything in the folder is touched.
        checkpoints = Checkpoints(long_run, network, fingerprint(assembly, names, points, algorithm))
        found = checkpoints.load() if long_run.resume else None
        store = Folder(long_run.folder)
        if found is not None:
            store = Folder(long_run.folder, keep=found.rows, digest=found.digest)
    recorder = Recorder(network, names, points, store)
    if line is not None:
        file = None if long_run is None else long_run.folder / VALUES
        line.began(Sketch(recorder.names, recorder.units, points, tuple(balances), file))
    if checkpoints is not None and found is None:
        checkpoints.forget()
    return Run(network, recorder, stepper, algorithm, tuple(balances), checkpoints, found)


@dataclass
class Run:
    """One run under way."""

    network: Network
    recorder: Recorder
    stepper: Stepper
    algorithm: Algorithm
    balances: tuple[Balance, ...]
    checkpoints: Checkpoints | None = None
    found: Checkpoint | None = None
    clock: Clock | None = None
    progress: Progress | None = None
    compiled: bool = False
    check_stability: bool = True
    _sweeps: int = 0
    _start: tuple[Snapshot, object] | None = None

    def result(self, assembly: Assembly) -> Result:
        """Do the run and say how it went."""
        recorder, network = self.recorder, self.network
        failure: SlaveError | str | None = None
        began = time.perf_counter()
        try:
            with Interruption() as interruption:
                self._begin(assembly)
                began = time.perf_counter()
                if not self._step_through(interruption):
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
        )
        remarks = (*self.stepper.remarks, *self._stability(failure))
        conduct = tuple(told for slave in network.slaves for told in slave.remarks)
        table = recorder.table()
        return Result(
            table,
            "completed" if failure is None else "stopped",
            None if failure is None else str(failure),
            failure if isinstance(failure, SlaveError) else None,
            tuple(audit(table, balance) for balance in self.balances),
            (*conduct, *remarks),
            statistics,
        )

    def _inner(self) -> Algorithm:
        return self.algorithm.inner if isinstance(self.algorithm, Retry) else self.algorithm

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
            f"{type(self._inner()).__name__} is unstable here with steps of {points.step_size:g} s: a "
            f"disturbance of the exchanged values grows {factor:.3g} times in a step; take smaller steps or "
            "an iterated algorithm",
        )

    def _interrupted(self) -> str:
        recorder = self.recorder
        return f"interrupted at {recorder.points.time(max(recorder.rows - 1, 0)):g} s"

    def _begin(self, assembly: Assembly) -> None:
        """Initialize, or go on from a checkpoint."""
        self._sweeps = initialize(self.network, self.recorder.points, assembly.values)
        if self.found is None or self.checkpoints is None:
            self.recorder.take(0)
        else:
            self._sweeps = self.checkpoints.restore(self.found, self.recorder, self.stepper)
            self.found = None
        inner = self._inner()
        explicit = isinstance(inner, Jacobi | GaussSeidel)
        if self.check_stability and explicit and not self.network.unable_to_restore():
            self._start = (self.network.snapshot(), self.stepper.memory())

    def _step_through(self, interruption: Interruption) -> bool:
        """Step over all communication points that are not recorded yet; False where Ctrl-C came."""
        recorder, points, stepper = self.recorder, self.recorder.points, self.stepper
        stride, last = max(1, points.count // 200), points.count
        loop, first = None, recorder.rows
        while recorder.rows <= last:
            self.network.end_copies()
            if interruption.asked:
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
                stepper.step(points.time(recorder.rows - 1), points.step_size)
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
        return CompiledLoop(self.network, self._inner(), self.recorder, self.recorder.points)

"""A whole run: initialize, step to the end or to a failure, give back what was recorded."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence

from warmlink.orchestration.master.algorithm import Algorithm, Stepper
from warmlink.orchestration.master.assembly import Assembly, assemble
from warmlink.orchestration.master.audit import Balance, audit, heat_balances
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.initialization import initialize
from warmlink.orchestration.master.jacobi import Jacobi
from warmlink.orchestration.master.network import Network
from warmlink.orchestration.master.recorder import Recorder, Table, outputs_of, times_of
from warmlink.orchestration.master.result import Result, Statistics
from warmlink.orchestration.master.slave import SlaveError
from warmlink.orchestration.system.model import System

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
    progress: Progress | None = None,
) -> Result:
    """Run a system from start to stop time.

    Parameters
    ----------
    system : System or Assembly
        An assembly's slaves are terminated at the end.
    stop_time, step_size, start_time : float
        In s; the step must divide the time between start and stop.
    algorithm : Algorithm, optional
        Default: Jacobi.
    record : sequence of str, optional
        Variables as `slave.variable`; default: every output.
    balances : sequence of Balance, optional
        Default: every heat balance found in the system; both ends are recorded.
    progress : callable, optional
        Called with communication steps done and to do, about 200 times a run.

    Returns
    -------
    Result
        With status `stopped` where a slave failed; the values up to there are kept.

    Raises
    ------
    InputError
        Where what was asked for cannot be run.
    """
    points = CommunicationPoints.between(start_time, stop_time, step_size)
    assembly = assemble(system) if isinstance(system, System) else system
    try:
        return _simulate(assembly, points, algorithm or Jacobi(), record, balances, progress)
    finally:
        for slave in assembly.slaves:
            # A slave that fails to end changes nothing about the run that lies behind.
            with contextlib.suppress(SlaveError):
                slave.terminate()
        assembly.close()


def _simulate(
    assembly: Assembly,
    points: CommunicationPoints,
    algorithm: Algorithm,
    record: Sequence[str] | None,
    balances: Sequence[Balance] | None,
    progress: Progress | None,
) -> Result:
    if balances is None:
        balances = heat_balances(assembly.slaves, assembly.connections)
    names = list(outputs_of(assembly.slaves) if record is None else record)
    for balance in balances:
        names += [balance.delivered, balance.received]
    outputs = set(outputs_of(assembly.slaves))
    network = Network(assembly.slaves, assembly.connections, [n for n in names if n in outputs])
    recorder = Recorder(network, names, points)
    stepper = algorithm.bind(network)
    failure: SlaveError | str | None = None
    sweeps, began = 0, time.perf_counter()
    try:
        sweeps = initialize(network, points, assembly.values)
        recorder.take(0)
        began = time.perf_counter()
        step_through(stepper, recorder, points, progress)
    except SlaveError as error:
        failure = error
    except KeyboardInterrupt:
        failure = f"interrupted at {points.time(max(recorder.rows - 1, 0)):g} s"
    statistics = Statistics(max(recorder.rows - 1, 0), network.steps, sweeps, time.perf_counter() - began)
    table = Table(
        recorder.names, recorder.units, times_of(points, recorder.rows), recorder.values[: recorder.rows]
    )
    audits = tuple(audit(table, balance) for balance in balances)
    if failure is None:
        return Result(table, "completed", audits=audits, statistics=statistics)
    culprit = failure if isinstance(failure, SlaveError) else None
    return Result(table, "stopped", str(failure), culprit, audits, statistics)


def step_through(
    stepper: Stepper, recorder: Recorder, points: CommunicationPoints, progress: Progress | None
) -> None:
    """Step over all communication points that are not recorded yet."""
    stride = max(1, points.count // 200)
    for point in range(recorder.rows, points.count + 1):
        stepper.step(points.time(point - 1), points.step_size)
        recorder.take(point)
        if progress is not None and (point % stride == 0 or point == points.count):
            progress(point, points.count)

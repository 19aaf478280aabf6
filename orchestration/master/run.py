"""A whole run of a system: from the files to the recorded values."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import cast

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.jacobi import Jacobi
from warmlink.orchestration.master.algorithms.retry import Retry
from warmlink.orchestration.master.assembly import Assembly, assemble
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.compiled.layout import obstacle
from warmlink.orchestration.master.compiled.loop import Stepping, choose
from warmlink.orchestration.master.pacing import Clock, Pacing
from warmlink.orchestration.master.recording.audit import Balance, heat_balances
from warmlink.orchestration.master.recording.checkpoint import Checkpoints, LongRun, fingerprint
from warmlink.orchestration.master.recording.line import Line
from warmlink.orchestration.master.recording.recorder import Recorder, outputs_of
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.recording.stores import VALUES, Store
from warmlink.orchestration.master.slaves.isolation import Isolation
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.master.slaves.slave import Slave, SlaveError
from warmlink.orchestration.master.slaves.timed import TimedSlave
from warmlink.orchestration.master.stepping import Progress, Run
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
    pacing: Pacing | None = None,
    check_stability: bool = True,
    statistics: bool = False,
    progress: Progress | None = None,
    line: Line | None = None,
) -> Result:
    """Run a system from start to stop time.

    Parameters
    ----------
    system : System or Assembly
        An assembly's slaves are terminated at the end.
    stop_time, step_size, start_time : float
        In s; the step must divide the time between start and stop. Times of all points, in place of a step,
        lay out steps that differ.
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
        `plain`, `compiled`, `preferred`: compiled if that is possible, or `auto`: if it is faster, too. The
        values are the same.
    long_run : LongRun, optional
        Write the values to disk during the run, write checkpoints, resume.
    pacing : Pacing, optional
        Keep pace with real time.
    check_stability : bool
        After a run by Jacobi or Gauss-Seidel, with slaves that can restore their states, go back to its
        beginning and check whether a small disturbance grows; this is not done in a paced run.
    statistics : bool
        Count and time the calls of every slave, which plain stepping makes.
    progress : callable, optional
        Called with communication steps done and to do, about 200 times in a run.
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
    if isinstance(step_size, Sequence):
        points = CommunicationPoints.at(step_size)
    else:
        points = CommunicationPoints.between(start_time, stop_time, step_size)
    algorithm = algorithm or Jacobi()
    if not algorithm.repeats_steps:
        algorithm = Retry(algorithm)
    whole = algorithm.whole_steps
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
        compiled = choose(stepping, whole, points, len(assembly.slaves))
        if balances is None:
            balances = heat_balances(assembly.slaves, assembly.connections)
        outputs = outputs_of(assembly.slaves)
        ends = [end for balance in balances for end in (balance.delivered, balance.received)]
        names = list(dict.fromkeys([*(outputs if record is None else record), *ends]))
        network = Network(assembly.slaves, assembly.connections, sorted(set(names) & set(outputs)), process)
        stepper = algorithm.bind(network, points)
        # Whatever is wrong with the checkpoint shows before anything in the folder is touched.
        marks = fingerprint(assembly, names, points, algorithm)
        checkpoints = None if long_run is None else Checkpoints(long_run, network, marks)
        store = Store(line) if checkpoints is None else checkpoints.store()
        recorder = Recorder(network, names, points, store)
        if line is not None:
            file = None if long_run is None else long_run.folder / VALUES
            line.began(Result(recorder.header, "stopped", balances=tuple(balances)), file)
        if checkpoints is not None and checkpoints.found is None:
            checkpoints.forget()
        hindrance = obstacle(network, recorder) if compiled else None
        if hindrance is not None and stepping == "compiled":
            raise InputError(f"compiled stepping: {hindrance}; choose plain stepping")
        run = Run(
            network,
            recorder,
            stepper,
            whole,
            assembly.values,
            tuple(balances),
            checkpoints,
            None if pacing is None else Clock(pacing),
            progress if line is None else line.progress,
            compiled=compiled and hindrance is None,
            check_stability=check_stability and pacing is None and whole.explicit,
        )
        result = run.result()
        network.end_copies()
        if line is not None:
            line.keep(result)
        network.release()
        return result
    finally:
        for slave in assembly.slaves:
            # A slave that fails to end changes nothing about the run that lies behind.
            with contextlib.suppress(SlaveError):
                slave.terminate()
        assembly.close()

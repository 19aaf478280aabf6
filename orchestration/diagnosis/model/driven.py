"""One run of a system of FMUs whose inputs follow a log; in a process of its own, as FMUs may crash."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import cache
from multiprocessing import get_context
from typing import Any, NamedTuple

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.cache import cache_folder
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.model.simulation import NotSimulatedError, halved
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel
from warmlink.orchestration.master.assembly import assemble
from warmlink.orchestration.master.compiled.loop import library
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.library import Batch, sorted_by_type
from warmlink.orchestration.master.slaves.other_process import without_main
from warmlink.orchestration.master.slaves.slave import Names, SlaveError
from warmlink.orchestration.system.assemble import end_of
from warmlink.orchestration.system.model import Capabilities, Connection, FmuVariable, System, Value

LOG = "measured log"
"""Name of the slave that plays the log."""


class Driven(NamedTuple):
    """What a run takes: FMUs with start values in the variables' own units, what is wanted, and the log.

    `signals` are courses of inputs and tunable parameters that do not stay as they start, by full name and in
    their own units, at communication points in s from 0, shape (points,) each.
    """

    system: System
    signals: Mapping[str, Array]
    outputs: tuple[str, ...]
    time: Array

    def halved(self) -> Driven:
        """The same with half of each step."""
        signals = {name: np.repeat(signal, 2)[:-1] for name, signal in self.signals.items()}
        return self._replace(signals=signals, time=halved(self.time))


def courses(runs: Sequence[Driven]) -> list[Array]:
    """Outputs of each run in the variables' own units, shape (points, outputs) each, on all cores.

    Raises
    ------
    NotSimulatedError
        A run ended early.
    InputError
        An FMU ended its process.
    """
    try:
        with without_main():
            waiting = [_pool().submit(_course, run) for run in runs]
        return [each.result() for each in waiting]
    except BrokenProcessPool:
        _pool.cache_clear()
        names = ", ".join(runs[0].system.components)
        raise InputError(
            f"{runs[0].system.name}: one of its FMUs ended the process that it ran in ({names}); "
            "try each by itself with `warmlink check`"
        ) from None


@cache
def _pool() -> ProcessPoolExecutor:
    return ProcessPoolExecutor(os.cpu_count(), get_context("spawn"))


def _course(run: Driven) -> Array:
    """What `courses` gives for one run, in a process of the pool."""
    unpacked = cache_folder() / "unpacked" / str(os.getpid())
    unpacked.mkdir(parents=True, exist_ok=True)
    try:
        assembly, log = assemble(run.system, unpacked=unpacked), _Log(run)
        assembly.slaves = [log, *assembly.slaves]
        assembly.connections = [*log.wires(), *assembly.connections]
        result = simulate(
            assembly,
            float(run.time[-1]),
            run.time.tolist(),
            GaussSeidel(),
            start_time=float(run.time[0]),
            record=run.outputs,
            balances=(),
            stepping="preferred",
            check_stability=False,
        )
    except SlaveError as fault:
        raise NotSimulatedError(f"{run.system.name}: {fault}") from None
    if result.status != "completed":
        raise NotSimulatedError(f"{run.system.name}: {result.reason}")
    return np.column_stack([result[name] for name in run.outputs])


class _Laid(ctypes.Structure):
    """The log as the compiled loop has it, see `Log` in `loop.c`."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("values", "times")),
        *((name, ctypes.c_int64) for name in ("points", "width", "point")),
    )


class _Log:
    """A slave that gives, after a step, what held at its beginning: the next slaves step with that."""

    name, prefix, plain_step, stepping, forward_only = LOG, "fmi2", True, 0, False
    capabilities = Capabilities(variable_step=True, get_set_state=True)
    accepts_nan: frozenset[str] = frozenset()
    remarks: Sequence[str] = ()

    def __init__(self, run: Driven) -> None:
        self._run = run
        self.variables: Mapping[str, FmuVariable] = {
            target: FmuVariable(target, i, "Real", "Real", "output", "continuous")
            for i, target in enumerate(run.signals)
        }
        self.dependencies: Mapping[str, frozenset[str]] = dict.fromkeys(run.signals, frozenset())
        self._table = np.column_stack([np.empty((run.time.size, 0)), *run.signals.values()])
        at = self._table.ctypes.data, run.time.ctypes.data
        self._laid = _Laid(*at, run.time.size, len(run.signals), 0)
        self.component = ctypes.cast(ctypes.byref(self._laid), ctypes.c_void_p)

    def wires(self) -> Iterator[Connection]:
        """Connections to the inputs that follow the log."""
        for target in self.variables:
            yield Connection(LOG, target, *end_of(self._run.system.components, target, LOG))

    def function(self, name: str) -> Any:
        return getattr(library(), {"DoStep": "log_step"}.get(name, "log_get"))

    def batches(self, names: Names) -> list[Batch]:
        return sorted_by_type(LOG, self.prefix, self.variables, names, {})

    def get(self, names: Names) -> list[Value]:
        return [float(self._run.signals[name][self._laid.point]) for name in names]

    def step(self, time: float, step_size: float) -> None:
        self._laid.point = max(int(np.searchsorted(self._run.time, time, side="right")) - 1, 0)

    def state(self, reuse: object = None) -> object:
        return self._laid.point

    def restore(self, state: object) -> None:
        self._laid.point = state

    def serialize(self) -> bytes:
        return b""

    def _nothing(self, *_: object) -> None:
        """What a log need not do."""

    set = setup = enter_initialization = exit_initialization = terminate = free = _nothing
    set_input_derivatives = deserialize = _nothing

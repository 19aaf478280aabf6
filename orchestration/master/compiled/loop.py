"""Stepping by a compiled loop: when it pays, and what happens between its chunks."""

from __future__ import annotations

import importlib.util
import sys
import time
from typing import Literal

import numpy as np

from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Schedule
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.compiled.layout import Layout
from warmlink.orchestration.master.recording.recorder import Recorder
from warmlink.orchestration.master.slaves import fmi, under_way
from warmlink.orchestration.master.slaves.network import Network, Snapshot

Stepping = Literal["auto", "plain", "compiled"]

# A plain step of one slave takes about 3 µs; loading Numba and its cache takes about a second.
PAYS_FROM_SLAVE_STEPS = 500_000
PAYS_WHEN_LOADED_FROM = 5_000
CHUNK_SECONDS = 0.05
_DISCARD = 2
_KERNEL = "warmlink.orchestration.master.compiled.kernel"


def prepare() -> None:
    """Compile the loop or load it from Numba's cache; call it before any FMU is loaded.

    Raises
    ------
    InputError
        Where Numba is not installed, or an FMU was loaded in this process before: compiled after a Python
        FMU was loaded, processes crashed at their exit.
    """
    if is_loaded():
        return
    if importlib.util.find_spec("numba") is None:
        raise MissingExtraError("compiled stepping", "studies")
    if fmi.LOADED:
        raise InputError(
            "compiled stepping: is no longer possible in this process, in which FMUs were loaded before it "
            "was prepared; choose auto"
        )
    try:
        importlib.import_module(_KERNEL)
    except (ImportError, RuntimeError, OSError) as fault:  # half installed, or its cache cannot be written
        sys.modules.pop(_KERNEL, None)
        raise InputError(f"compiled stepping: Numba does not work here ({fault}); choose auto") from None


def try_to_prepare() -> bool:
    """Do as `prepare`, where that can be done; tell whether the compiled loop is there."""
    try:
        prepare()
    except InputError:  # which steps plainly, and gives the same values
        return False
    return True


def is_loaded() -> bool:
    """Tell whether the compiled loop is there."""
    return _KERNEL in sys.modules


def choose(stepping: Stepping, algorithm: Algorithm, points: CommunicationPoints, slaves: int) -> bool:
    """Decide before the FMUs are loaded whether to step by the compiled loop, and prepare it.

    Parameters
    ----------
    stepping : str
        `auto` takes it where it can be had and the run is long enough to pay for loading it.
    algorithm : Algorithm
        Jacobi with held inputs and Gauss-Seidel can be compiled.
    points : CommunicationPoints
        The run's.
    slaves : int
        How many there are.

    Raises
    ------
    InputError
        Where `compiled` was asked for and cannot be had.
    """
    if stepping == "plain":
        return False
    if stepping == "compiled":
        if not algorithm.compiles:
            raise InputError(
                f"compiled stepping: {algorithm} cannot be compiled; choose Jacobi with held inputs "
                "or Gauss-Seidel"
            )
        prepare()
        return True
    pays = points.count * slaves >= (PAYS_WHEN_LOADED_FROM if is_loaded() else PAYS_FROM_SLAVE_STEPS)
    return algorithm.compiles and pays and try_to_prepare()


class CompiledLoop:
    """Steps a network by the compiled loop, in chunks after which Python may look around.

    Parameters
    ----------
    network : Network
        Initialized; without `obstacle`.
    schedule : Schedule
        Of an algorithm that compiles.
    recorder : Recorder
        Its rows are filled directly.
    points : CommunicationPoints
        The run's.
    """

    def __init__(
        self, network: Network, schedule: Schedule, recorder: Recorder, points: CommunicationPoints
    ) -> None:
        from warmlink.orchestration.master.compiled import kernel

        self._kernel = kernel
        self.network = network
        self.recorder = recorder
        self.layout = Layout(network, recorder)
        self.layout.load()
        self._at_once = schedule.at_once
        self._order = np.array(schedule.slaves, dtype=np.int64)
        self._times = np.array([points.start_time, points.step_size])
        self._points = points
        self._restores = not network.unable_to_restore()
        self._keyframe: Snapshot | None = None
        self._cells = np.frombuffer(under_way.here.cells, dtype=np.int64)
        self._chunk = 256

    def advance(self, last: int) -> bool:
        """Step on, at most to point `last` and for about 50 ms; SlaveError where something fails for good.

        False where a step was discarded and everything is back at the start of the chunk, so that plain
        stepping can repeat it in parts.
        """
        network, recorder = self.network, self.recorder
        first = recorder.rows - 1
        last = min(last, first + self._chunk, first + recorder.room())
        if self._restores:
            self._keyframe = network.snapshot(reuse=self._keyframe)
        failure = self._cells
        failure[:3] = 0
        began = time.perf_counter()
        reached = self._kernel.advance(
            self._at_once,
            self._order,
            first,
            last,
            self._times,
            self.layout.tables,
            self.layout.factors,
            self.layout.buffers,
            self.layout.ranges,
            recorder.block,
            recorder.place(first + 1),
            failure,
        )
        took = time.perf_counter() - began
        self._chunk = max(16, min(1 << 20, int(self._chunk * min(4.0, CHUNK_SECONDS / max(took, 1e-6)))))
        # After an error a slave may not be able to go back, after a fatal one it must not be called.
        if failure[0] == self._kernel.STEP and failure[2] == _DISCARD and self._keyframe is not None:
            network.rewind(self._keyframe)
            return False
        self.layout.unload()
        network.time = self._points.time(reached)
        network.steps += (reached - first) * len(network.slaves)
        recorder.filled(reached)
        if failure[0]:
            self._raise(reached, *(int(f) for f in failure[:3]))
        return True

    def _raise(self, reached: int, what: int, k: int, detail: int) -> None:
        """Raise what plain stepping would have raised."""
        kernel, network = self._kernel, self.network
        slave = self.layout.slaves[max(k, 0)]
        slave.time = self._points.time(reached)
        if what == kernel.NOT_FINITE:
            network.time = self._points.time(reached) + self._points.step_size
            network.check(k, network.outputs[k])
        if what == kernel.TERMINATE:
            slave.end("DoStep")
        slave.fail({kernel.STEP: "DoStep", kernel.GET: "Get"}.get(what, "Set"), detail)

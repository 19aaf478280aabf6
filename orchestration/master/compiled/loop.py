"""Stepping by a compiled loop: when it pays, and what happens between its chunks."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Literal, cast

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Schedule
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.compiled import kernel
from warmlink.orchestration.master.compiled.layout import Layout
from warmlink.orchestration.master.recording.recorder import Recorder
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.network import Network, Snapshot

if TYPE_CHECKING:
    from warmlink.orchestration.master.slaves.fmi import FmiSlave

Stepping = Literal["auto", "preferred", "plain", "compiled"]

PAYS_FROM_SLAVE_STEPS = 5_000
CHUNK_SECONDS = 0.05
_DISCARD = 2


def stepping_named(name: str) -> Stepping:
    """Give the way to step by its name; InputError where there is none of that name."""
    kinds: tuple[Stepping, ...] = ("auto", "plain", "compiled")
    for kind in kinds:
        if name == kind:
            return kind
    raise InputError(f"--stepping {name}: not known; {instead(name, kinds)}")


def prepare() -> None:
    """Compile the loop, or take what was compiled before; InputError where there is no C compiler."""
    try:
        kernel.library()
    except (InputError, OSError) as fault:
        raise InputError(f"compiled stepping: {fault}; choose auto") from None


def choose(stepping: Stepping, algorithm: Algorithm, points: CommunicationPoints, slaves: int) -> bool:
    """Decide whether to step by the compiled loop, and prepare it.

    Parameters
    ----------
    stepping : str
        `auto` takes it where it can be had and the run is long enough to pay for laying out its tables,
        `preferred` wherever it can be had, as one run of many does.
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
    short = stepping == "auto" and points.count * slaves < PAYS_FROM_SLAVE_STEPS
    if not algorithm.compiles or short:
        return False
    try:
        prepare()
    except InputError:  # stepping plainly gives the same values
        return False
    return True


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
        self.network = network
        self.recorder = recorder
        self.layout = Layout(network, recorder)
        self.layout.load()
        self._at_once = schedule.at_once
        self._order = np.array(schedule.slaves, dtype=np.int64)
        self._times = np.array([points.start_time, points.step_size, *points.uneven])
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
        reached = kernel.advance(
            self._at_once,
            self._order,
            first,
            last,
            self._times,
            self.layout,
            recorder.block,
            recorder.place(first + 1),
            failure,
        )
        took = time.perf_counter() - began
        self._chunk = max(16, min(1 << 20, int(self._chunk * min(4.0, CHUNK_SECONDS / max(took, 1e-6)))))
        # After an error a slave may not be able to go back, after a fatal one it must not be called.
        if failure[0] == kernel.STEP and failure[2] == _DISCARD and self._keyframe is not None:
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
        network = self.network
        slave = cast("FmiSlave", network.slaves[max(k, 0)])  # nothing else fails in compiled code
        slave.time = self._points.time(reached)
        if what == kernel.NOT_FINITE:
            network.time = self._points.time(reached) + self._points.step(reached)
            network.check(k, network.outputs[k])
        if what == kernel.TERMINATE:
            slave.end("DoStep")
        slave.fail({kernel.STEP: "DoStep", kernel.GET: "Get"}.get(what, "Set"), detail)

"""Stepping by a loop in C, compiled by this machine's compiler once and kept: when, and in which chunks."""

from __future__ import annotations

import ctypes
import time
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Literal, cast

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.packaging.cache import kept
from warmlink.fmus.packaging.native.library import loaded, made_here
from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Schedule
from warmlink.orchestration.master.communication import CommunicationPoints
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
_NOTHING, _STEP, _GET, _SET, _NOT_FINITE, _TERMINATE = range(6)
"""What failed, as the loop notes in the first cell of `under_way`."""


def stepping_named(name: str) -> Stepping:
    """Give the way to step by its name; InputError where there is none of that name."""
    kinds: tuple[Stepping, ...] = ("auto", "plain", "compiled")
    for kind in kinds:
        if name == kind:
            return kind
    raise InputError(f"--stepping {name}: not known; {instead(name, kinds)}")


@cache
def library() -> ctypes.CDLL:
    """The loop; InputError if it is not kept and there is no C compiler."""
    text = (Path(__file__).parent / "sources" / "loop.c").read_text("utf-8")

    def compiled() -> bytes:
        from warmlink.fmus.packaging.native.compile import compilers, platforms_named

        (compiler,) = compilers(platforms_named(None))
        return compiler.library({"loop.c": text}, "loop")

    found = loaded(kept("loops", (*made_here(), text), compiled))
    found.advance.restype = ctypes.c_int64
    return found


def prepare() -> None:
    """Compile the loop, or take what was compiled before; InputError where there is no C compiler."""
    try:
        library()
    except (InputError, OSError) as fault:
        raise InputError(f"compiled stepping: {fault}; choose auto") from None


def choose(stepping: Stepping, algorithm: Algorithm, schedule: Schedule | None, slave_steps: int) -> bool:
    """Decide whether to step by the compiled loop, and prepare it.

    `auto` takes it where it can be had and so many steps of slaves pay for laying out its tables, `preferred`
    wherever it can be had, as one run of many does; InputError where `compiled` cannot be had.
    """
    compiles = schedule is not None and not schedule.again
    if stepping == "compiled" and not compiles:
        raise InputError(
            f"compiled stepping: {algorithm} cannot be compiled; choose Jacobi with held inputs "
            "or Gauss-Seidel"
        )
    short = stepping == "auto" and slave_steps < PAYS_FROM_SLAVE_STEPS
    if stepping == "plain" or short or not compiles:
        return False
    try:
        prepare()
    except InputError:
        if stepping == "compiled":
            raise
        return False  # stepping plainly gives the same values
    return True


class CompiledLoop:
    """Steps an initialized network by the compiled loop, in chunks after which Python may look around.

    The recorder's rows are filled directly.
    """

    def __init__(
        self, network: Network, schedule: Schedule, recorder: Recorder, points: CommunicationPoints
    ) -> None:
        self.network, self.recorder = network, recorder
        self.layout = Layout(network, schedule, recorder, points)
        self.layout.load()
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
        row = recorder.left
        last = min(last, first + self._chunk, first + len(row))
        if self._restores:
            self._keyframe = network.snapshot(reuse=self._keyframe)
        failure = self._cells
        failure[:3] = 0
        began = time.perf_counter()
        assert row.dtype == np.float64
        assert row.flags.c_contiguous
        ends = ctypes.c_int64(first), ctypes.c_int64(last)
        tables, rows, cells = (
            ctypes.c_void_p(each.ctypes.data) for each in (self.layout.tables, row, failure)
        )
        reached = int(library().advance(tables, *ends, rows, cells))
        took = time.perf_counter() - began
        self._chunk = max(16, min(1 << 20, int(self._chunk * min(4.0, CHUNK_SECONDS / max(took, 1e-6)))))
        # After an error a slave may not be able to go back, after a fatal one it must not be called.
        if failure[0] == _STEP and failure[2] == _DISCARD and self._keyframe is not None:
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
        if what == _NOT_FINITE:
            network.time = self._points.time(reached) + self._points.step(reached)
            network.check(k, network.outputs[k])
        if what in (_STEP, _TERMINATE):
            slave.stop(detail)
        slave.fail("Get" if what == _GET else "Set", detail)

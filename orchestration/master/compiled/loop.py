"""Stepping by a loop in C, compiled by this machine's compiler once and kept: when, and over which tables."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Sequence
from functools import cache
from itertools import accumulate, chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol, cast, runtime_checkable

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.packaging.cache import kept
from warmlink.fmus.packaging.native.library import loaded, made_here
from warmlink.orchestration.master.algorithms.algorithm import STEP, WRITE, Algorithm, Schedule
from warmlink.orchestration.master.recording.recorder import Recorder
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.library import Batch
from warmlink.orchestration.master.slaves.network import Network, SlaveStates
from warmlink.orchestration.master.slaves.slave import Names

if TYPE_CHECKING:
    from warmlink.orchestration.master.slaves.fmi import FmiSlave

Stepping = Literal["auto", "preferred", "plain", "compiled"]

PAYS_FROM_SLAVE_STEPS = 500
"""Steps of slaves from which on laying out the tables takes less time than the loop saves."""
CHUNK_SECONDS = 0.05
_DISCARD = 2
_NOTHING, _NOTE = -1, 3
"""Nothing failed; and what is done beside `STEP`, `READ` and `WRITE`: the recorder's variables are got."""


def stepping_named(name: str) -> Stepping:
    """Give the way to step by its name; InputError if none has that name."""
    kinds: dict[str, Stepping] = {"auto": "auto", "plain": "plain", "compiled": "compiled"}
    if name not in kinds:
        raise InputError(f"{argument('stepping', name)}: not known; {instead(name, kinds)}")
    return kinds[name]


@cache
def library() -> ctypes.CDLL:
    """The loop; InputError if it is not kept and there is no C compiler."""
    text = (Path(__file__).parent / "sources" / "loop.c").read_text("utf-8")

    def compiled() -> bytes:
        from warmlink.fmus.packaging.native.compile import library_here

        return library_here({"loop.c": text}, "loop")

    found = loaded(kept("loops", (*made_here(), text), compiled))
    pointer, whole = ctypes.c_void_p, ctypes.c_int64
    found.advance.restype, found.advance.argtypes = whole, (pointer, whole, whole, pointer, pointer)
    return found


def choose(stepping: Stepping, algorithm: Algorithm, schedule: Schedule | None, slave_steps: int) -> bool:
    """Decide whether to step by the compiled loop, and prepare it.

    `auto` takes it where it can be had and so many steps of slaves pay for laying out its tables, `preferred`
    wherever it can be had, as one run of many does; InputError where `compiled` cannot be had.
    """
    if stepping == "compiled" and schedule is None:
        raise InputError(f"compiled stepping: {algorithm} cannot be compiled; choose Jacobi or Gauss-Seidel")
    short = stepping == "auto" and slave_steps < PAYS_FROM_SLAVE_STEPS
    if stepping == "plain" or short or schedule is None:
        return False
    try:
        library()
    except (InputError, OSError) as fault:
        if stepping == "compiled":
            raise InputError(f"compiled stepping: {fault}; choose auto") from None
        return False  # stepping plainly gives the same values
    return True


# By FMI version and base type: the buffer (0 doubles, 1 ints, 2 bytes, 3 long ints).
_KINDS = {
    **{("fmi2", "Real"): 0, ("fmi2", "Integer"): 1, ("fmi2", "Boolean"): 1},
    **{("fmi3", "Float64"): 0, ("fmi3", "Int32"): 1, ("fmi3", "Boolean"): 2, ("fmi3", "Int64"): 3},
}
Place = tuple[int, int]
"""A buffer and an index in it."""


@runtime_checkable
class Addressed(Protocol):
    """What compiled code needs to step a slave by itself: its functions, as FMI has them in `prefix`."""

    prefix: str
    plain_step: bool
    component: Any
    stepping: int
    forward_only: bool

    def function(self, name: str) -> Any: ...  # noqa: D102
    def batches(self, names: Names) -> list[Batch]: ...  # noqa: D102


def obstacle(network: Network, recorder: Recorder) -> str | None:
    """Say why a network cannot be stepped by the compiled loop; None where it can."""
    for k, slave in enumerate(network.slaves):
        if not isinstance(slave, Addressed):
            return f"{slave.name} is not an FMU in this process"
        if not slave.plain_step:
            return f"{slave.name} takes more than one call for a step"
        if any(wire.limits for wire in network.wires[k]):
            return f"{slave.name} takes integers that it may not hold"
        if any(wire.values for wire in network.wires[k]):
            return f"{slave.name} takes values that a table changes"
        for names in (network.reads[k], network.writes[k], recorder.late[k]):
            for batch in slave.batches(names) if names else ():
                if batch.arrays:
                    return f"{slave.name} exchanges arrays"
                if (slave.prefix, batch.base) not in _KINDS:
                    return f"{slave.name} exchanges {batch.base} values"
    return None


class MemoryLayout:
    """Tables of addresses and indices that the compiled loop runs over: `tables`, as `Tables` in `loop.c`.

    The four buffers hold doubles, ints, bytes and long ints; each batch of a slave's variables has its
    stretch in one of them, so that FMI calls read and write there directly. Long ints lie behind the doubles,
    so that they are recorded bit by bit, as doubles are.
    """

    def __init__(self, network: Network, schedule: Schedule, recorder: Recorder) -> None:
        self.network, points = network, recorder.points
        self._slaves = cast("list[Addressed]", network.slaves)  # as `obstacle` found
        room = 4 + sum(len(names) for names in (*network.reads, *network.writes, *recorder.late))
        both = np.zeros(2 * room)
        small = (np.zeros(room, kind) for kind in (np.int32, np.bool_))
        self.buffers: list[Any] = [both[:room], *small, both[room:].view(np.int64)]
        self._used = [1, 0, 3, 0]  # lastSuccessfulTime and the flags of fmi3DoStep
        self.batches: list[Batch] = []  # in the order of their table, which holds their value references
        slaves, count = range(len(network.slaves)), len(network.slaves)
        reads, self.outputs = self._laid(network.reads, "Get")
        writes, self.inputs = self._laid(network.writes, "Set")
        late, late_places = self._laid(recorder.late, "Get")
        wires = [
            [(*self.outputs[w.slave][w.position], *target) for w, target in zip(*both, strict=True)]
            for both in zip(network.wires, self.inputs, strict=True)
        ]
        checks = [[self.outputs[k][position][1] for position in network.checked[k]] for k in slaves]
        columns = [
            late_places[k][recorder.late[k].index(name)] if position is None else self.outputs[k][position]
            for k, name, position in recorder.sources
        ]
        columns = [
            (0, room + index) if kind == _KINDS["fmi3", "Int64"] else (kind, index) for kind, index in columns
        ]
        factors = [each for w in chain(*network.wires) for each in (w.factor, w.offset)]
        batches = [*reads, *writes, *late]
        ends = _ends(batches)
        ranges = [_ends(wires), *(ends[first : first + count + 1] for first in (0, count, 2 * count))]
        jobs = [*schedule.jobs, *((_NOTE, k) for k in slaves if late[k])]
        steps = [
            [
                *(each.component.value, _address(each.function("DoStep"))),
                *(int(each.prefix[-1]), each.stepping, each.forward_only),
            ]
            for each in self._slaves
        ]
        rows = jobs, steps, *([*chain(*each)] for each in (batches, wires, checks))
        self._arrays: list[Any] = [
            *(np.array(each, dtype=np.int64) for each in (*rows, columns, [*ranges, _ends(checks)])),
            np.array(factors),
            np.array([points.start_time, points.step_size, *points.uneven]),
            *self.buffers,
        ]
        sizes = count, len(columns), len(jobs), len(points.uneven)
        self.tables = np.array([*sizes, *(array.ctypes.data for array in self._arrays)], dtype=np.int64)

    def load(self) -> None:
        """Take the values last exchanged into the buffers."""
        for places, values in ((self.outputs, self.network.outputs), (self.inputs, self.network.inputs)):
            for (kind, index), value in zip(chain(*places), chain(*values), strict=True):
                self.buffers[kind][index] = value

    def unload(self) -> None:
        """Give the values last exchanged back to the network."""
        held = self.buffers
        self.network.outputs = [[held[kind][at].item() for kind, at in places] for places in self.outputs]
        self.network.inputs = [[held[kind][at].item() for kind, at in places] for places in self.inputs]

    def _laid(self, names: Sequence[Names], verb: str) -> tuple[list[list[list[int]]], list[list[Place]]]:
        """Give for each slave the rows of the table of batches, and where each variable lies."""
        rows: list[list[list[int]]] = [[] for _ in names]
        places: list[list[Place]] = [[(0, 0)] * len(each) for each in names]
        for k, of_slave in enumerate(names):
            slave = self._slaves[k]
            for batch in slave.batches(of_slave) if of_slave else ():
                kind = _KINDS[slave.prefix, batch.base]
                start, buffer = self._used[kind], self.buffers[kind]
                self._used[kind] += batch.count
                self.batches.append(batch)
                for i, position in enumerate(batch.positions):
                    places[k][position] = (kind, start + i)
                function, references = slave.function(verb + batch.base), ctypes.addressof(batch.references)
                values, version = buffer.ctypes.data + start * buffer.itemsize, int(slave.prefix[-1])
                component = slave.component.value
                rows[k].append([_address(function), component, references, batch.count, values, version])
        return rows, places


def _address(function: Any) -> int:
    return ctypes.cast(function, ctypes.c_void_p).value or 0


def _ends(rows: Sequence[Sequence[Any]]) -> list[int]:
    """Where each slave's rows begin in the table of all, and the last one's end."""
    return [0, *accumulate(map(len, rows))]


class CompiledLoop:
    """Steps an initialized network by the compiled loop, in chunks after which Python may look around.

    The recorder's rows are filled directly. Where it `goes_back`, a discarded step can be repeated in parts.
    """

    def __init__(self, network: Network, schedule: Schedule, recorder: Recorder, *, goes_back: bool) -> None:
        self.network, self.recorder, self._points = network, recorder, recorder.points
        self._jobs = list(schedule.jobs)
        self.layout = MemoryLayout(network, schedule, recorder)
        self.layout.load()
        self._restores = goes_back and not network.unable_to_restore()
        self._keyframe: SlaveStates | None = None
        self._cells = np.frombuffer(recorder.cells, dtype=np.int64)
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
        failure[:3] = _NOTHING, 0, 0
        failure[under_way.ENDS] = 0
        began = time.perf_counter()
        tables, rows, cells = (each.ctypes for each in (self.layout.tables, row, failure))
        reached = library().advance(tables, first, last, rows, cells)
        took = time.perf_counter() - began
        if failure[under_way.TURNED]:
            cast("FmiSlave", network.slaves[int(failure[under_way.TURNED]) - 1]).turned()
            failure[under_way.TURNED] = 0
        self._chunk = max(16, min(1 << 20, int(self._chunk * min(4.0, CHUNK_SECONDS / max(took, 1e-6)))))
        # After an error a slave may not be able to go back, after a fatal one it must not be called.
        if failure[0] == STEP and failure[2] == _DISCARD and self._keyframe is not None:
            for slave in network.slaves:  # for what they say if they do not go back
                cast("FmiSlave", slave).time = self._points.time(reached)
            network.rewind(self._keyframe)
            return False
        self.layout.unload()
        network.time = self._points.time(reached)
        network.steps += (reached - first) * len(network.slaves)
        recorder.filled(reached)
        if failure[0] != _NOTHING:
            self._raise(reached, *(int(f) for f in failure[:3]))
        elif failure[under_way.ENDS]:
            k = int(failure[under_way.ENDS]) - 1
            network.ends[k] = cast("FmiSlave", network.slaves[k]).answered(0, self._points.step(reached - 1))
        return True

    def _raise(self, reached: int, what: int, k: int, detail: int) -> None:
        """Raise what plain stepping would have raised; finish a step after which a slave asks to end."""
        network = self.network
        slave = cast("FmiSlave", network.slaves[k])  # nothing else fails in compiled code
        slave.time = self._points.time(reached)
        if what == STEP:
            network.ends[k] = slave.answered(detail, self._points.step(reached))
            self._finish(reached, k)
            return
        if detail <= 1:  # it was got, but is not finite
            network.time = self._points.time(reached) + self._points.step(reached)
            network.check(k, network.outputs[k])
        batch = self.layout.batches[int(self._cells[under_way.BATCH])]
        slave.fail_exchange("Set" if what == WRITE else "Get", batch, detail)

    def _finish(self, reached: int, k: int) -> None:
        """Do plainly what is left of a step when slave `k` has stepped, and record its end."""
        network, time, step_size = self.network, self._points.time(reached), self._points.step(reached)
        network.time = time + step_size
        for deed, each in self._jobs[self._jobs.index((STEP, k)) + 1 :]:
            if deed == STEP:
                network.step(each, time, step_size)
            elif deed == WRITE:
                network.write(each)
            else:
                network.read(each)
        self.recorder.take()

"""The tables that the compiled loop runs over, and what cannot be put into them."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from itertools import accumulate, chain
from typing import Any, Protocol, runtime_checkable

import numpy as np

from warmlink.orchestration.master.algorithms.algorithm import Schedule
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.recorder import Recorder
from warmlink.orchestration.master.slaves.batch import Batch
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.master.slaves.slave import Names
from warmlink.orchestration.system.model import Value

# By FMI version and base type: the buffer (0 doubles, 1 ints, 2 bytes, 3 long ints).
_KINDS = {
    ("fmi2", "Real"): 0,
    ("fmi2", "Integer"): 1,
    ("fmi2", "Boolean"): 1,
    ("fmi3", "Float64"): 0,
    ("fmi3", "Int32"): 1,
    ("fmi3", "Boolean"): 2,
    ("fmi3", "Int64"): 3,
}
Place = tuple[int, int]
"""A buffer and an index in it."""


@runtime_checkable
class Addressed(Protocol):
    """What compiled code needs to step a slave by itself: the addresses of its functions, as FMI has them.

    They are called in the way of the `prefix`, `fmi2` or `fmi3`, with the `component` as first argument;
    `stepping` is what `under_way` calls a step.
    """

    prefix: str
    component: Any
    stepping: int

    def function(self, name: str) -> Any:
        """Find a function by its name without the prefix."""

    def batches(self, names: Names) -> list[Batch]:
        """Give a set of variables sorted by type."""


def obstacle(network: Network, recorder: Recorder) -> str | None:
    """Say why a network cannot be stepped by the compiled loop; None where it can."""
    for k, slave in enumerate(network.slaves):
        if not isinstance(slave, Addressed):
            return f"{slave.name} is not an FMU in this process"
        for names in (network.reads[k], network.writes[k], recorder.late[k]):
            for batch in slave.batches(names) if names else ():
                if batch.arrays:
                    return f"{slave.name} exchanges arrays"
                if (slave.prefix, batch.base) not in _KINDS:
                    return f"{slave.name} exchanges {batch.base} values"
    return None


class Layout:
    """Tables of addresses and indices that the compiled loop runs over: `tables`, as `Tables` in `loop.c`.

    The four buffers hold doubles, ints, bytes and long ints; each batch of a slave's variables has its
    stretch in one of them, so that FMI calls read and write there directly.
    """

    def __init__(
        self, network: Network, schedule: Schedule, recorder: Recorder, points: CommunicationPoints
    ) -> None:
        self.network = network
        room = 4 + sum(len(names) for names in (*network.reads, *network.writes, *recorder.late))
        self.buffers = [np.zeros(room, kind) for kind in (np.float64, np.int32, np.uint8, np.int64)]
        self._used = [1, 0, 3, 0]  # lastSuccessfulTime and the flags of fmi3DoStep
        self._kept: list[Batch] = []  # whose value references are in the tables
        slaves = range(len(network.slaves))
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
        factors = [each for w in chain(*network.wires) for each in (w.factor, w.offset)]
        ranges = [
            [0, *accumulate(len(of_slave) for of_slave in each)] for each in (reads, writes, wires, checks)
        ]
        read_rows = [*chain(*reads), *chain(*late)]
        self._arrays: list[Any] = [
            *(_whole(rows) for rows in (schedule.slaves, [self._row(k) for k in slaves], read_rows)),
            *(_whole(rows) for rows in ([*chain(*writes)], [*chain(*wires)], [*chain(*checks)], columns)),
            _whole(ranges),
            np.array(factors),
            np.array([points.start_time, points.step_size, *points.uneven]),
            *self.buffers,
        ]
        sizes = len(slaves), len(read_rows), len(columns), schedule.at_once, len(points.uneven)
        self.tables = np.array([*sizes, *(array.ctypes.data for array in self._arrays)], dtype=np.int64)

    def load(self) -> None:
        """Take the values last exchanged into the buffers."""
        for places, values in ((self.outputs, self.network.outputs), (self.inputs, self.network.inputs)):
            for (kind, index), value in zip(chain(*places), chain(*values), strict=True):
                self.buffers[kind][index] = value

    def unload(self) -> None:
        """Give the values last exchanged back to the network."""
        self.network.outputs = [[self._value(*place) for place in places] for places in self.outputs]
        self.network.inputs = [[self._value(*place) for place in places] for places in self.inputs]

    def _value(self, kind: int, index: int) -> Value:
        value: Value = self.buffers[kind][index].item()
        return bool(value) if kind == 2 else value

    def _row(self, k: int) -> list[int]:
        slave = self._slave(k)
        bytes_at, doubles_at = self.buffers[2].ctypes.data, self.buffers[0].ctypes.data
        version = int(slave.prefix[-1])
        step = _address(slave.function("DoStep"))
        return [slave.component.value, step, version, bytes_at, doubles_at, slave.stepping]

    def _laid(self, names: Sequence[Names], verb: str) -> tuple[list[list[list[int]]], list[list[Place]]]:
        """Give for each slave the rows of the table of batches, and where each variable lies."""
        rows: list[list[list[int]]] = [[] for _ in names]
        places: list[list[Place]] = [[(0, 0)] * len(each) for each in names]
        for k, of_slave in enumerate(names):
            slave = self._slave(k)
            for batch in slave.batches(of_slave) if of_slave else ():
                kind = _KINDS[slave.prefix, batch.base]
                start, buffer = self._used[kind], self.buffers[kind]
                self._used[kind] += batch.count
                self._kept.append(batch)
                for i, position in enumerate(batch.positions):
                    places[k][position] = (kind, start + i)
                function, references = slave.function(verb + batch.base), ctypes.addressof(batch.references)
                values, version = buffer.ctypes.data + start * buffer.itemsize, int(slave.prefix[-1])
                component = slave.component.value
                rows[k].append([_address(function), component, references, batch.count, values, version])
        return rows, places

    def _slave(self, k: int) -> Addressed:
        slave = self.network.slaves[k]
        assert isinstance(slave, Addressed)
        return slave


def _address(function: Any) -> int:
    return ctypes.cast(function, ctypes.c_void_p).value or 0


def _whole(rows: Any) -> Any:
    return np.array(rows, dtype=np.int64)

"""The tables that the compiled loop runs over, and what cannot be put into them."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.master.recording.recorder import Recorder
from warmlink.orchestration.master.slaves.batch import Batch
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.master.slaves.slave import Addressed, Names
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
Numbers = NDArray[np.int64]


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
    """Tables of addresses and indices that the compiled loop runs over.

    The four buffers hold doubles, ints, bytes and long ints; each batch of a slave's variables has its
    stretch in one of them, so that FMI calls read and write there directly.
    """

    def __init__(self, network: Network, recorder: Recorder) -> None:
        self.network = network
        self.slaves = [slave for slave in network.slaves if isinstance(slave, Addressed)]
        self._sizes = [0, 0, 3, 0]  # the first three bytes are the flags of fmi3DoStep
        self._keep: list[Batch] = []
        count = len(network.slaves)
        plans = [self._plan(k, network.reads[k], "Get") for k in range(count)]
        writes = [self._plan(k, network.writes[k], "Set") for k in range(count)]
        late = [self._plan(k, recorder.late[k], "Get") for k in range(count)]
        self._sizes[0] += 1  # lastSuccessfulTime of fmi3DoStep
        self.buffers = (
            np.zeros(self._sizes[0]),
            np.zeros(max(1, self._sizes[1]), dtype=np.int32),
            np.zeros(self._sizes[2], dtype=np.uint8),
            np.zeros(max(1, self._sizes[3]), dtype=np.int64),
        )
        self.outputs = [places for _, places in plans]
        self.inputs = [places for _, places in writes]
        late_places = {
            (k, name): place
            for k in range(count)
            for name, place in zip(recorder.late[k], late[k][1], strict=True)
        }
        self._wires(count)
        checks = [[self.outputs[k][position][1] for position in network.checked[k]] for k in range(count)]
        columns = [
            late_places[k, name] if position is None else self.outputs[k][position]
            for k, name, position in recorder.sources
        ]
        rows = [row for batches, _ in plans for row in batches]
        late_rows = [row for batches, _ in late for row in batches]
        write_rows = [row for batches, _ in writes for row in batches]
        self.tables = (
            _table([self._row(k) for k in range(count)], 6),
            self._finish(rows + late_rows),
            self._finish(write_rows),
            _table(self.wire_rows, 4),
            np.array([c for found in checks for c in found], dtype=np.int64),
            _table(columns, 2),
        )
        self.ranges = np.array(
            [
                _starts([len(batches) for batches, _ in plans]),
                _starts([len(batches) for batches, _ in writes]),
                _starts([len(wires) for wires in network.wires]),
                _starts([len(found) for found in checks]),
            ],
            dtype=np.int64,
        )

    def load(self) -> None:
        """Take the values last exchanged into the buffers."""
        for places, values in ((self.outputs, self.network.outputs), (self.inputs, self.network.inputs)):
            for of_slave, values_of_slave in zip(places, values, strict=True):
                for (kind, index), value in zip(of_slave, values_of_slave, strict=True):
                    self.buffers[kind][index] = value

    def unload(self) -> None:
        """Give the values last exchanged back to the network."""
        for k in range(len(self.network.slaves)):
            self.network.outputs[k] = [self._python(k, place) for place in self.outputs[k]]
            self.network.inputs[k] = [self._python(k, place) for place in self.inputs[k]]

    def _python(self, k: int, place: Place) -> Value:
        kind, index = place
        value = self.buffers[kind][index].item()
        return bool(value) if kind == 2 else value

    def _row(self, k: int) -> list[int]:
        slave = self.slaves[k]
        assert slave.component.value is not None
        last = self.buffers[0].ctypes.data + 8 * (len(self.buffers[0]) - 1)
        return [
            slave.component.value,
            _address(slave.function("DoStep")),
            int(slave.prefix[-1]),
            self.buffers[2].ctypes.data,
            last,
            slave.stepping,
        ]

    def _plan(self, k: int, names: Names, verb: str) -> tuple[list[list[int]], list[Place]]:
        """Give the rows of the table of batches, and where each variable lies."""
        slave = self.slaves[k]
        rows: list[list[int]] = []
        places: list[Place] = [(0, 0)] * len(names)
        for batch in slave.batches(names) if names else ():
            kind = _KINDS[slave.prefix, batch.base]
            start = self._sizes[kind]
            self._sizes[kind] += batch.count
            for i, position in enumerate(batch.positions):
                places[position] = (kind, start + i)
            self._keep.append(batch)
            assert slave.component.value is not None
            rows.append(
                [
                    _address(slave.function(verb + batch.base)),
                    slave.component.value,
                    ctypes.addressof(batch.references),
                    batch.count,
                    kind << 32 | start,
                    int(slave.prefix[-1]),
                ]
            )
        return rows, places

    def _finish(self, rows: list[list[int]]) -> NDArray[np.int64]:
        """Turn buffer positions into addresses, now that the buffers are there."""
        for row in rows:
            kind, start = row[4] >> 32, row[4] & 0xFFFFFFFF
            row[4] = self.buffers[kind].ctypes.data + start * self.buffers[kind].itemsize
        return _table(rows, 6)

    def _wires(self, count: int) -> None:
        self.wire_rows: list[list[int]] = []
        factors: list[float] = []
        for k in range(count):
            for target, wire in zip(self.inputs[k], self.network.wires[k], strict=True):
                source = self.outputs[wire.slave][wire.position]
                self.wire_rows.append([*source, *target])
                factors += [wire.factor, wire.offset]
        self.factors = np.array(factors)


def _address(function: Any) -> int:
    return ctypes.cast(function, ctypes.c_void_p).value or 0


def _table(rows: Sequence[Sequence[int]], columns: int) -> NDArray[np.int64]:
    return np.array(rows, dtype=np.int64).reshape(-1, columns)


def _starts(lengths: Sequence[int]) -> list[int]:
    return [0, *np.cumsum(lengths, dtype=np.int64).tolist()]

"""What is kept of a run: chosen variables at every communication point."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.stores import Store
from warmlink.orchestration.master.recording.table import Table
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.master.slaves.slave import Names, Slave
from warmlink.orchestration.system.description import Variable


def outputs_of(slaves: Sequence[Slave]) -> tuple[str, ...]:
    """Name every scalar output that is a number, as `slave.variable`."""
    return tuple(
        f"{slave.name}.{v.name}" for slave in slaves for v in slave.variables.values() if is_recorded(v)
    )


def is_recorded(variable: Variable) -> bool:
    """Tell whether a variable is recorded unasked: an output that is a scalar number."""
    return (
        variable.causality == "output" and variable.kind not in (None, "String") and not variable.dimensions
    )


class Recorder:
    """Values in rows of a preallocated block, a row for each communication point.

    Parameters
    ----------
    network : Network
        Must read the outputs among `names`.
    names : sequence of str
        Variables as `slave.variable`; outputs are kept as they were exchanged, all others (inputs,
        parameters, internals) as they stand when the exchange is done.
    points : CommunicationPoints
        The run's.
    store : Store
        Takes full blocks and gives everything back at the end.

    Attributes
    ----------
    header : Table
        What is recorded, without values.
    block : ndarray, shape (rows of a block, names)
        In the variables' own units; Booleans are 0 and 1.
    rows : int
        Points recorded so far.
    sources : list of (slave, variable, position)
        For each column, its position among the outputs read from the slave, or None.
    late : list of tuple of str
        For each slave, the variables that are got anew after the exchange.
    """

    def __init__(
        self, network: Network, names: Sequence[str], points: CommunicationPoints, store: Store
    ) -> None:
        names = tuple(dict.fromkeys(names))
        self.points = points
        self.rows = 0
        self._cells = under_way.here.cells
        units: dict[str, str | None] = {}
        self.sources: list[tuple[int, str, int | None]] = []
        self._network, count = network, len(network.slaves)
        for name in names:
            k, variable = network.locate(name)
            about = network.slaves[k].variables[variable]
            if about.kind in (None, "String") or about.dimensions:
                raise InputError(f"{name}: a {about.type} cannot be recorded; choose a scalar number")
            units[name] = about.unit
            read = network.reads[k]
            self.sources.append((k, variable, read.index(variable) if variable in read else None))
        late = [[c for c, (j, _, p) in enumerate(self.sources) if j == k and p is None] for k in range(count)]
        self.late: list[Names] = [tuple(self.sources[c][1] for c in columns) for columns in late]
        self._others = [(k, self.late[k], columns) for k, columns in enumerate(late) if columns]
        self._exchanged = [(c, k, p) for c, (k, _, p) in enumerate(self.sources) if p is not None]
        self.store = store
        self.header = Table(names, units, points, np.empty((0, len(names))))
        self.block = store.open(self.header)
        self._base = 0

    def take(self, point: int) -> None:
        """Keep the values of one communication point."""
        row = self.block[self.place(point)]
        outputs = self._network.outputs
        for column, k, position in self._exchanged:
            row[column] = outputs[k][position]
        for k, names, columns in self._others:
            row[columns] = self._network.slaves[k].get(names)
        self.filled(point)

    def place(self, point: int) -> int:
        """Give the row of the block for a point."""
        return point - self._base

    def room(self) -> int:
        """Tell how many more points fit into the block."""
        return len(self.block) - self.place(self.rows)

    def filled(self, point: int) -> None:
        """Note that all rows up to a point are filled; hand a full block to the store."""
        self.rows = self._cells[under_way.ROWS] = point + 1
        if self.room() == 0 and self.rows <= self.points.count:
            self.flush()

    def flush(self) -> None:
        """Hand what the block holds to the store and begin it anew."""
        self.store.put(self._base, self.block[: self.place(self.rows)])
        self._base = self.rows

    def resume(self, rows: int) -> None:
        """Go on behind rows that the store holds already."""
        self.rows = self._base = self._cells[under_way.ROWS] = rows

    def table(self) -> Table:
        """Give everything recorded."""
        return self.header.holding(self.store.values(self._base, self.block[: self.place(self.rows)]))

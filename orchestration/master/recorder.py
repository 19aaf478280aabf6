"""What is kept of a run: chosen variables at every communication point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.network import Network
from warmlink.orchestration.master.slave import Slave

if TYPE_CHECKING:
    import pandas


def outputs_of(slaves: Sequence[Slave]) -> tuple[str, ...]:
    """Name every scalar output that is a number, as `slave.variable`."""
    return tuple(
        f"{slave.name}.{v.name}"
        for slave in slaves
        for v in slave.variables.values()
        if v.causality == "output" and v.kind not in (None, "String") and not v.dimensions
    )


class Recorder:
    """Values in rows of one preallocated array, a row for each communication point.

    Parameters
    ----------
    network : Network
        Must read the outputs among `names`.
    names : sequence of str
        Variables as `slave.variable`; outputs are kept as they were exchanged, all others (inputs,
        parameters, internals) as they stand when the exchange is done.
    points : CommunicationPoints
        The run's.

    Attributes
    ----------
    values : ndarray, shape (count + 1, names)
        In the variables' own units; Booleans are 0 and 1.
    rows : int
        Rows filled so far.
    """

    def __init__(self, network: Network, names: Sequence[str], points: CommunicationPoints) -> None:
        self.names = tuple(dict.fromkeys(names))
        self.points = points
        self.rows = 0
        self.values: NDArray[np.float64] = np.full((points.count + 1, len(self.names)), np.nan)
        self.units: dict[str, str | None] = {}
        self._network = network
        self._exchanged: list[tuple[int, int, int]] = []
        others: dict[int, list[tuple[int, str]]] = {}
        for column, name in enumerate(self.names):
            k, variable = network.locate(name)
            about = network.slaves[k].variables[variable]
            if about.kind in (None, "String") or about.dimensions:
                raise InputError(f"{name}: a {about.type} cannot be recorded; choose a scalar number")
            self.units[name] = about.unit
            if variable in network.reads[k]:
                self._exchanged.append((column, k, network.reads[k].index(variable)))
            else:
                others.setdefault(k, []).append((column, variable))
        self._others = [
            (k, tuple(name for _, name in found), [column for column, _ in found])
            for k, found in others.items()
        ]

    def take(self, point: int) -> None:
        """Keep the values of one communication point."""
        row = self.values[point]
        outputs = self._network.outputs
        for column, k, position in self._exchanged:
            row[column] = outputs[k][position]
        for k, names, columns in self._others:
            row[columns] = self._network.slaves[k].get(names)
        self.rows = point + 1


class Table:
    """Recorded columns with their times.

    Attributes
    ----------
    times : ndarray, shape (points,)
        In s.
    values : ndarray, shape (points, columns)
        In the units of `units`.
    """

    def __init__(
        self,
        names: Sequence[str],
        units: dict[str, str | None],
        times: NDArray[np.float64],
        values: NDArray[np.float64],
    ) -> None:
        self.names = tuple(names)
        self.units = units
        self.times = times
        self.values = values
        self._column = {name: column for column, name in enumerate(self.names)}

    def __contains__(self, name: str) -> bool:
        return name in self._column

    def __len__(self) -> int:
        return len(self.times)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Give one column, shape (points,)."""
        if name not in self._column:
            raise KeyError(f"{name} was not recorded; recorded: {', '.join(self.names)}")
        return self.values[:, self._column[name]]

    def heading(self, name: str) -> str:
        """Give a column's heading, as `link.elongation [m]`."""
        return f"{name} [{self.units[name] or '1'}]"

    def to_frame(self) -> pandas.DataFrame:
        """Give a data frame whose columns are named `time [s]`, `link.elongation [m]` and so on."""
        import pandas

        frame = pandas.DataFrame(self.values, columns=[self.heading(name) for name in self.names])
        frame.insert(0, "time [s]", self.times)
        return frame


def times_of(points: CommunicationPoints, rows: int) -> NDArray[np.float64]:
    """Give the times in s of the first communication points, as `CommunicationPoints.time` does."""
    return points.start_time + np.arange(rows, dtype=np.float64) * points.step_size

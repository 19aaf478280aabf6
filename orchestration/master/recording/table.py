"""Recorded columns with their times."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.master.communication import CommunicationPoints

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, eq=False)
class Table:
    """Values at the first communication points of a run; a file on disk may stand behind them.

    Attributes
    ----------
    names : tuple of str
        As `slave.variable`.
    units : mapping
        Unit by name; None where the slave gives none.
    points : CommunicationPoints
        The run's.
    values : ndarray, shape (points, columns)
        In those units.
    """

    names: tuple[str, ...]
    units: Mapping[str, str | None]
    points: CommunicationPoints
    values: NDArray[np.float64] = field(repr=False)

    @cached_property
    def _column(self) -> dict[str, int]:
        return {name: column for column, name in enumerate(self.names)}

    @property
    def times(self) -> NDArray[np.float64]:
        """Times in s, shape (points,)."""
        rows = np.arange(len(self), dtype=np.float64)
        if self.points.uneven:
            return np.array(self.points.uneven[: rows.size])
        return self.points.start_time + rows * self.points.step_size

    def __contains__(self, name: str) -> bool:
        return name in self._column

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Give one column, shape (points,)."""
        if name not in self._column:
            raise KeyError(f"{name} was not recorded; recorded: {', '.join(self.names)}")
        return self.values[:, self._column[name]]

    def holding(self, values: NDArray[np.float64]) -> Table:
        """Give the same columns with other values."""
        return replace(self, values=values)

    def heading(self, name: str) -> str:
        """Give a column's heading, as `link.elongation [m]`."""
        return f"{name} [{self.units[name] or '1'}]"

    def to_frame(self) -> pandas.DataFrame:
        """Give a data frame whose columns are named `time [s]`, `link.elongation [m]` and so on."""
        import pandas

        frame = pandas.DataFrame(np.asarray(self.values), columns=[self.heading(name) for name in self.names])
        frame.insert(0, "time [s]", self.times)
        return frame

"""The result of a run: recorded columns, how heat balances came out, and what it took."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.console import Answer
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.slaves.slave import CALLS, Slave, SlaveError, SlaveStatistics
from warmlink.orchestration.system.model import Connection

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, eq=False)
class RecordTable:
    """Values at the first communication points of a run; a file on disk may stand behind them.

    The names are `slave.variable`; a unit is None where the slave gives none; the values in those units have
    the shape (points, columns). Integers of 64 bits, which a double may not hold, lie there bit by bit: the
    `types` of such columns are `int64` or `uint64`, and `[]` gives them as integers.
    """

    names: tuple[str, ...]
    units: Mapping[str, str | None]
    points: CommunicationPoints
    values: Array = field(repr=False)
    types: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def _column(self) -> dict[str, int]:
        return {name: column for column, name in enumerate(self.names)}

    @property
    def times(self) -> Array:
        """Times in s, shape (points,)."""
        rows = np.arange(len(self), dtype=np.float64)
        if self.points.uneven:
            return np.array(self.points.uneven[: rows.size])
        return self.points.start_time + rows * self.points.step_size

    def __contains__(self, name: str) -> bool:
        return name in self._column

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, name: str) -> Array:
        """Give one column, shape (points,)."""
        if name not in self._column:
            raise KeyError(f"{name} was not recorded; recorded: {', '.join(self.names)}")
        column: Array = self.values[:, self._column[name]]
        return column.view(self.types[name]) if name in self.types else column

    def holding(self, values: Array) -> RecordTable:
        """Give the same columns with other values."""
        return replace(self, values=values)

    def heading(self, name: str) -> str:
        """Give a column's heading, as `link.elongation [m]`."""
        return f"{name} [{self.units[name] or '1'}]"

    def to_frame(self) -> pandas.DataFrame:
        """Give a data frame whose columns are named `time [s]`, `link.elongation [m]` and so on."""
        import pandas

        frame = pandas.DataFrame(np.asarray(self.values), columns=[self.heading(name) for name in self.names])
        for name in self.types:
            frame[self.heading(name)] = np.asarray(self[name])
        frame.insert(0, "time [s]", self.times)
        return frame


@dataclass(frozen=True)
class Balance:
    """Two cumulative outputs that should grow alike, in one unit, as `link.heat_received`."""

    delivered: str
    received: str


@dataclass(frozen=True)
class Audit:
    """A balance evaluated over a recorded run, in the unit of both ends."""

    balance: Balance
    table: RecordTable = field(repr=False)

    @property
    def unit(self) -> str | None:
        """Unit of both ends."""
        return self.table.units[self.balance.delivered]

    @property
    def delivered(self) -> float:
        """What was delivered over the run."""
        return _gained(self.table[self.balance.delivered])

    @property
    def total(self) -> float:
        """Delivered minus received over the run."""
        return self.delivered - _gained(self.table[self.balance.received])

    @property
    def per_step(self) -> Array:
        """Delivered minus received in each communication step, shape (steps,)."""
        return np.diff(self.table[self.balance.delivered] - self.table[self.balance.received])

    @property
    def largest_step(self) -> float:
        """Largest absolute difference within one step."""
        return float(np.max(np.abs(self.per_step), initial=0.0))


def _gained(column: Array) -> float:
    return float(column[-1] - column[0]) if len(column) else 0.0


def heat_balances(slaves: Sequence[Slave], connections: Iterable[Connection]) -> tuple[Balance, ...]:
    """Find what counts the `heat_delivered` of a `heat_flow`, and what its `heat_received`, unconverted."""
    variables = {slave.name: slave.variables for slave in slaves}
    return tuple(
        Balance(f"{c.source_component}.heat_delivered", f"{c.target_component}.heat_received")
        for c in connections
        if (c.source_variable, c.target_variable) == ("heat_flow", "heat_flow")
        and (c.factor, c.offset) == (1.0, 0.0)
        and "heat_delivered" in variables[c.source_component]
        and "heat_received" in variables[c.target_component]
    )


_MOST_SIZES = 4
"""Of steps, the most frequent ones, that the table shows."""


@dataclass(frozen=True)
class Statistics:
    """Number of steps and time that a run took.

    `slave_steps` are steps of single slaves, repeated ones included; `rejected_steps` macro steps, or parts
    of them, that were undone and repeated with a smaller step; `limits_the_step` the slave on whose account
    most of them were, if any; `initialization_sweeps` until the feedthrough loops had settled;
    `wall_seconds` of stepping alone; `largest_lag` the largest delay behind real time in s of a paced run;
    `slaves` what each was asked for, where that was to be counted; `memory_bytes` the largest memory that the
    process has held, 0 where the platform does not tell. Of the `communication_steps`, those
    `resumed_steps` were done before the run was resumed, which times and calls do not count.
    """

    communication_steps: int = 0
    resumed_steps: int = 0
    slave_steps: int = 0
    rejected_steps: int = 0
    limits_the_step: str | None = None
    initialization_sweeps: int = 0
    wall_seconds: float = 0.0
    compiled: bool = False
    largest_lag: float = 0.0
    slaves: tuple[SlaveStatistics, ...] = ()
    memory_bytes: int = 0

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        found = asdict(self)
        for each in found["slaves"]:
            each["step_sizes"] = {f"{size:g}": count for size, count in sorted(each["step_sizes"].items())}
        return found

    def table(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Headings and rows for people: a row for each slave, times in ms."""
        headings = ("FMU", "steps", "sizes in s", "refused", "rollbacks", *(f"{name} ms" for name in CALLS))
        rows = []
        for each in self.slaves:
            often = sorted(each.step_sizes.items(), key=lambda of: -of[1])
            sizes = ", ".join(f"{size:.3g} ({count})" for size, count in often[:_MOST_SIZES])
            sizes += f", {len(often) - _MOST_SIZES} more" if len(often) > _MOST_SIZES else ""
            step, restored = each.calls["step"], each.calls["restore"].count
            times = (f"{1e3 * each.calls[name].seconds:.1f}" for name in CALLS)
            rows.append((each.name, str(step.count), sizes, str(step.refused), str(restored), *times))
        return headings, rows

    def summary(self) -> str:
        """Whole figures in a line."""
        limited = f", most for {self.limits_the_step}" if self.limits_the_step else ""
        before = f"; {self.resumed_steps} were done before" if self.resumed_steps else ""
        count = self.communication_steps - self.resumed_steps
        done = f"{count} communication steps in {self.wall_seconds:.3g} s"
        repeated = f"{self.rejected_steps} repeated in parts{limited}"
        return f"{done}, {repeated}; memory {self.memory_bytes / 2**20:.0f} MB{before}"


@dataclass(frozen=True, repr=False)
class Result(Answer):
    """A run's values up to its end, or up to the point where it stopped.

    Attributes
    ----------
    table : times and recorded columns
    status : `completed`, `ended` by a slave that asked for it, or `stopped`; the latter two for a `reason` in
        one sentence, behind which there may be an `error`
    balances : pairs of recorded columns that should grow alike
    remarks : sentences that say what the slaves did not allow, and what was done instead
    """

    table: RecordTable
    status: Literal["completed", "ended", "stopped"]
    reason: str | None = None
    error: SlaveError | None = None
    balances: tuple[Balance, ...] = ()
    remarks: tuple[str, ...] = ()
    statistics: Statistics = field(default_factory=Statistics)

    @property
    def times(self) -> Array:
        """Times of the communication points in s, shape (points,)."""
        return self.table.times

    @property
    def stopped(self) -> str | None:
        """Why the run stopped; None if it completed, or a slave ended it."""
        return self.reason if self.status == "stopped" else None

    @property
    def audits(self) -> tuple[Audit, ...]:
        """How each balance came out."""
        return tuple(Audit(balance, self.table) for balance in self.balances)

    def __getitem__(self, name: str) -> Array:
        """Give a recorded column by its full name, shape (points,)."""
        return self.table[name]

    def summary(self) -> str:
        """How far the run came, and what it holds."""
        ended = f"to {self.times[-1]:g} s" if len(self.times) else "none"
        told = (
            f"; {'ended' if self.status == 'ended' else 'stopped early'}: {self.reason}"
            if self.reason
            else ""
        )
        return f"{len(self.times)} communication points, {ended}, of {len(self.table.names)} variables{told}"

    def to_frame(self) -> pandas.DataFrame:
        """Give a data frame with units in its column names."""
        return self.table.to_frame()

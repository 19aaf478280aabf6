"""The result of a run."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.console import Answer
from warmlink.orchestration.master.recording.audit import Audit, Balance
from warmlink.orchestration.master.recording.table import Table
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.master.slaves.timed import CALLS, SlaveStatistics

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class Statistics:
    """Number of steps and time that a run took.

    Attributes
    ----------
    communication_steps : int
        Macro steps done.
    slave_steps : int
        Steps of single slaves, repeated ones included.
    rejected_steps : int
        Macro steps, or parts of them, that were undone and repeated with a smaller step.
    initialization_sweeps : int
        Sweeps until the feedthrough loops had settled.
    wall_seconds : float
        Of stepping alone.
    compiled : bool
        Whether the compiled loop did it.
    largest_lag : float
        Largest delay behind real time in s, in a paced run.
    slaves : tuple of SlaveStatistics
        What each slave was asked for, where that was to be counted.
    memory_bytes : int
        Largest memory that the process has held; 0 where the platform does not tell.
    """

    communication_steps: int = 0
    slave_steps: int = 0
    rejected_steps: int = 0
    initialization_sweeps: int = 0
    wall_seconds: float = 0.0
    compiled: bool = False
    largest_lag: float = 0.0
    slaves: tuple[SlaveStatistics, ...] = ()
    memory_bytes: int = 0

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON; the FMU that refused most steps is the one that limits them."""
        found = asdict(self)
        for each in found["slaves"]:
            each["step_sizes"] = {f"{size:g}": count for size, count in sorted(each["step_sizes"].items())}
        refused = {each.name: each.calls["step"].refused for each in self.slaves}
        found["limits_the_step"] = max(refused, key=refused.__getitem__) if any(refused.values()) else None
        return found

    def table(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Headings and rows for people: a row for each slave, times in ms."""
        headings = ("FMU", "steps", "sizes in s", "refused", "rollbacks", *(f"{name} ms" for name in CALLS))
        rows = []
        for each in self.slaves:
            sizes = ", ".join(f"{size:g} ({count})" for size, count in sorted(each.step_sizes.items())[:4])
            step, restored = each.calls["step"], each.calls["restore"].count
            times = (f"{1e3 * each.calls[name].seconds:.1f}" for name in CALLS)
            rows.append((each.name, str(step.count), sizes, str(step.refused), str(restored), *times))
        return headings, rows

    def summary(self) -> str:
        """Whole figures in a line."""
        return (
            f"{self.communication_steps} communication steps in {self.wall_seconds:.3g} s, "
            f"{self.rejected_steps} repeated in parts; memory {self.memory_bytes / 2**20:.0f} MB"
        )


@dataclass(frozen=True, repr=False)
class Result(Answer):
    """A run's values up to its end, or up to the point where it stopped.

    Attributes
    ----------
    table : Table
        Times and recorded columns.
    status : str
        `completed` or `stopped`.
    reason : str or None
        Why it stopped, in one sentence.
    error : SlaveError or None
        The failure behind it: slave, variable, status and time.
    remarks : tuple of str
        Sentences that say what the slaves did not allow, and what was done instead.
    balances : tuple of Balance
        Pairs of recorded columns that should grow alike.
    """

    table: Table
    status: Literal["completed", "stopped"]
    reason: str | None = None
    error: SlaveError | None = None
    balances: tuple[Balance, ...] = ()
    remarks: tuple[str, ...] = ()
    statistics: Statistics = field(default_factory=Statistics)

    @property
    def times(self) -> NDArray[np.float64]:
        """Times of the communication points in s, shape (points,)."""
        return self.table.times

    @property
    def audits(self) -> tuple[Audit, ...]:
        """How each balance came out."""
        return tuple(Audit(balance, self.table) for balance in self.balances)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Give a recorded column by its full name, shape (points,)."""
        return self.table[name]

    def summary(self) -> str:
        """How far the run came, and what it holds."""
        ended = f"to {self.times[-1]:g} s" if len(self.times) else "none"
        told = f"; stopped early: {self.reason}" if self.reason else ""
        return f"{len(self.times)} communication points, {ended}, of {len(self.table.names)} variables{told}"

    def to_frame(self) -> pandas.DataFrame:
        """Give a data frame with units in its column names."""
        return self.table.to_frame()

"""Balances of cumulative outputs: what left one slave and did not reach the other."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.master.recording.table import Table
from warmlink.orchestration.master.slaves.slave import Slave
from warmlink.orchestration.system.model import Connection


@dataclass(frozen=True)
class Balance:
    """Two cumulative outputs that should grow alike, both in the same unit.

    Attributes
    ----------
    delivered, received : str
        As `motor.heat_delivered` and `link.heat_received`.
    """

    delivered: str
    received: str


@dataclass(frozen=True)
class Audit:
    """A balance evaluated over a recorded run."""

    balance: Balance
    table: Table = field(repr=False)

    @property
    def unit(self) -> str | None:
        """Unit of both ends."""
        return self.table.units[self.balance.delivered]

    @property
    def delivered(self) -> float:
        """What was delivered over the run, in `unit`."""
        column = self.table[self.balance.delivered]
        return float(column[-1] - column[0]) if len(column) else 0.0

    @property
    def total(self) -> float:
        """Delivered minus received over the run, in `unit`."""
        column = self.table[self.balance.received]
        return self.delivered - (float(column[-1] - column[0]) if len(column) else 0.0)

    @property
    def per_step(self) -> NDArray[np.float64]:
        """Delivered minus received in each communication step, in `unit`, shape (steps,)."""
        return np.diff(self.table[self.balance.delivered] - self.table[self.balance.received])

    @property
    def largest_step(self) -> float:
        """Largest absolute difference within one step, in `unit`."""
        return float(np.max(np.abs(self.per_step), initial=0.0))


def heat_balances(slaves: Sequence[Slave], connections: Iterable[Connection]) -> tuple[Balance, ...]:
    """Find the heat balances of a system.

    Wherever a slave that counts `heat_delivered` feeds its `heat_flow` to a slave that counts
    `heat_received`, unconverted and alone, the two counts belong together.
    """
    variables = {slave.name: slave.variables for slave in slaves}
    return tuple(
        Balance(f"{c.source_component}.heat_delivered", f"{c.target_component}.heat_received")
        for c in connections
        if (c.source_variable, c.target_variable) == ("heat_flow", "heat_flow")
        and (c.factor, c.offset) == (1.0, 0.0)
        and "heat_delivered" in variables[c.source_component]
        and "heat_received" in variables[c.target_component]
    )

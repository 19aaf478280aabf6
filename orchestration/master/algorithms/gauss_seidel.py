"""Gauss-Seidel: slaves step one after the other, each with the newest values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from warmlink.orchestration.master.algorithms.algorithm import Schedule
from warmlink.orchestration.master.algorithms.explicit import Explicit
from warmlink.orchestration.master.algorithms.ordering import feedthrough_order, named_order
from warmlink.orchestration.master.slaves.network import Network


@dataclass(frozen=True)
class GaussSeidel(Explicit):
    """Set a slave's inputs from the newest outputs, step it, read its outputs; then the next.

    Parameters
    ----------
    sequence : tuple of str, optional
        The slaves' names in the order of stepping; default: by direct feedthrough.
    """

    sequence: tuple[str, ...] | None = None
    compiles: ClassVar[bool] = True

    def schedule(self, network: Network) -> Schedule:
        """One slave after the other."""
        given = self.sequence
        slaves = feedthrough_order(network) if given is None else named_order(network, given)
        return Schedule(slaves, at_once=False)

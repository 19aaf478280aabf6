"""Jacobi: all slaves step at once, then all values are exchanged."""

from __future__ import annotations

from dataclasses import dataclass

from warmlink.orchestration.master.algorithms.algorithm import Schedule
from warmlink.orchestration.master.algorithms.explicit import Explicit
from warmlink.orchestration.master.algorithms.ordering import feedthrough_order
from warmlink.orchestration.master.slaves.network import Network


@dataclass(frozen=True)
class Jacobi(Explicit):
    """Step every slave with held inputs, read all outputs, set all inputs.

    An output with direct feedthrough is thus read with the old inputs at the new time, as libcosim's
    fixed-step algorithm and Ecos do it.

    Parameters
    ----------
    settled : bool
        After the exchange, read outputs with direct feedthrough again, now with the new inputs, and pass
        them on: all values then belong to the same communication point. Three times as accurate on a
        motor and its link; not what libcosim and Ecos do.
    """

    settled: bool = False

    @property
    def compiles(self) -> bool:
        """Only as libcosim and Ecos do it."""
        return not self.settled

    def schedule(self, network: Network) -> Schedule:
        """All slaves at once."""
        again = feedthrough_order(network) if self.settled else ()
        return Schedule(tuple(range(len(network.slaves))), at_once=True, again=again)

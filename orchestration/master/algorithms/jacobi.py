"""Jacobi: all slaves step at once, then all values are exchanged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Memoryless, Schedule
from warmlink.orchestration.master.algorithms.ordering import feedthrough_order
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.network import Network


@dataclass(frozen=True)
class Jacobi(Algorithm):
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
    order: ClassVar[int] = 1
    explicit: ClassVar[bool] = True

    @property
    def compiles(self) -> bool:
        """Only as libcosim and Ecos do it."""
        return not self.settled

    def schedule(self, network: Network) -> Schedule:
        """All slaves at once."""
        return Schedule(tuple(range(len(network.slaves))), at_once=True)

    def bind(self, network: Network, points: CommunicationPoints) -> JacobiStepper:
        """Prepare for one network."""
        return JacobiStepper(network, feedthrough_order(network) if self.settled else ())


class JacobiStepper(Memoryless):
    """Jacobi on one network; slaves in `again` are read again after the exchange, in that order."""

    def __init__(self, network: Network, again: tuple[int, ...] = ()) -> None:
        self.network = network
        self.again = again
        self._slaves = range(len(network.slaves))

    def step(self, time: float, step_size: float) -> None:
        """Advance all slaves by one communication step."""
        network = self.network
        for k in self._slaves:
            network.step(k, time, step_size)
        for k in self._slaves:
            network.read(k)
        for k in self._slaves:
            network.write(k)
        for k in self.again:
            network.write(k)
            network.read(k)
        if self.again:
            for k in self._slaves:
                network.write(k)

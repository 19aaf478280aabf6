"""Gauss-Seidel: slaves step one after the other, each with the newest values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Memoryless, Schedule
from warmlink.orchestration.master.algorithms.ordering import feedthrough_order, named_order
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.network import Network


@dataclass(frozen=True)
class GaussSeidel(Algorithm):
    """Set a slave's inputs from the newest outputs, step it, read its outputs; then the next.

    Parameters
    ----------
    sequence : tuple of str, optional
        The slaves' names in the order of stepping; default: by direct feedthrough.
    """

    sequence: tuple[str, ...] | None = None
    order: ClassVar[int] = 1
    explicit: ClassVar[bool] = True
    compiles: ClassVar[bool] = True

    def schedule(self, network: Network) -> Schedule:
        """One slave after the other."""
        given = self.sequence
        slaves = feedthrough_order(network) if given is None else named_order(network, given)
        return Schedule(slaves, at_once=False)

    def bind(self, network: Network, points: CommunicationPoints) -> GaussSeidelStepper:
        """Prepare for one network."""
        return GaussSeidelStepper(network, self.schedule(network).slaves)


class GaussSeidelStepper(Memoryless):
    """Gauss-Seidel on one network, in one order."""

    def __init__(self, network: Network, sequence: tuple[int, ...]) -> None:
        self.network = network
        self.sequence = sequence

    def step(self, time: float, step_size: float) -> None:
        """Advance all slaves by one communication step."""
        network = self.network
        for k in self.sequence:
            network.write(k)
            network.step(k, time, step_size)
            network.read(k)

"""Jacobi: all slaves step at once, then all values are exchanged."""

from __future__ import annotations

from dataclasses import dataclass

from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.extrapolation import Extrapolation
from warmlink.orchestration.master.network import Network
from warmlink.orchestration.master.ordering import feedthrough_order


@dataclass(frozen=True)
class Jacobi:
    """Step every slave with held inputs, read all outputs, set all inputs.

    An output with direct feedthrough is thus read with the old inputs at the new time, as libcosim's
    fixed-step algorithm and Ecos do it.

    Parameters
    ----------
    extrapolation : int
        Order 0 (held), 1 or 2 of the inputs during a step, where slaves take input derivatives.
    settled : bool
        After the exchange, read outputs with direct feedthrough again, now with the new inputs, and pass
        them on: all values then belong to the same communication point. Three times as accurate on a
        motor and its link; not what libcosim and Ecos do.
    """

    extrapolation: int = 0
    settled: bool = False

    @property
    def order(self) -> int:
        """Order of convergence of the coupling error.

        The first step has no past and is held, which limits a run to order two.
        """
        return min(2, 1 + self.extrapolation)

    def bind(self, network: Network, points: CommunicationPoints) -> JacobiStepper:
        """Prepare for one network."""
        again = feedthrough_order(network) if self.settled else ()
        return JacobiStepper(network, Extrapolation(network, self.extrapolation), again)


class JacobiStepper:
    """Jacobi on one network."""

    def __init__(self, network: Network, extrapolation: Extrapolation, again: tuple[int, ...] = ()) -> None:
        self.network = network
        self.extrapolation = extrapolation
        self.remarks = extrapolation.remarks
        self.again = again
        self._slaves = range(len(network.slaves))

    def step(self, time: float, step_size: float) -> None:
        """Advance all slaves by one communication step."""
        network = self.network
        if self.extrapolation.order:
            self.extrapolation.history.start(time)
            for k in self._slaves:
                self.extrapolation.apply(k, time)
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
        self.extrapolation.history.keep(time + step_size)

    def memory(self) -> object:
        """Give the past inputs."""
        return self.extrapolation.history.memory()

    def recall(self, memory: object) -> None:
        """Take the past inputs."""
        self.extrapolation.history.recall(memory)

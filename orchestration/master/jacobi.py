"""Jacobi: all slaves step at once, then all values are exchanged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from warmlink.orchestration.master.algorithm import Memoryless
from warmlink.orchestration.master.network import Network


@dataclass(frozen=True)
class Jacobi:
    """Step every slave with held inputs, read all outputs, set all inputs.

    An output with direct feedthrough is thus read with the old inputs at the new time, as libcosim's
    fixed-step algorithm and Ecos do it.
    """

    order: ClassVar[int] = 1

    def bind(self, network: Network) -> JacobiStepper:
        """Prepare for one network."""
        return JacobiStepper(network)


class JacobiStepper(Memoryless):
    """Jacobi on one network."""

    def __init__(self, network: Network) -> None:
        self.network = network
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

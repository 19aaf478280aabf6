"""What Jacobi and Gauss-Seidel have in common: every slave steps once, by a schedule, with known inputs."""

from __future__ import annotations

from typing import ClassVar

from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Schedule, Stepper
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.slaves.network import Network


class Explicit(Algorithm):
    """An algorithm that is nothing but its schedule."""

    order: ClassVar[int] = 1
    explicit: ClassVar[bool] = True

    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network."""
        return ScheduledStepper(network, self.schedule(network))


class ScheduledStepper(Stepper):
    """Steps one network by a schedule."""

    def __init__(self, network: Network, schedule: Schedule) -> None:
        self.network = network
        self.schedule = schedule

    def step(self, time: float, step_size: float) -> None:
        """Advance all slaves by one communication step."""
        network, slaves, again = self.network, self.schedule.slaves, self.schedule.again
        if not self.schedule.at_once:
            for k in slaves:
                network.write(k)
                network.step(k, time, step_size)
                network.read(k)
            return
        for k in slaves:
            network.step(k, time, step_size)
        for k in slaves:
            network.read(k)
        for k in slaves:
            network.write(k)
        for k in again:
            network.write(k)
            network.read(k)
        for k in slaves if again else ():
            network.write(k)

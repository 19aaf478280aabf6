"""Jacobi and Gauss-Seidel: every slave steps once, by a schedule, with inputs that are known already."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.algorithm import READ, STEP, WRITE, Algorithm, Schedule, Stepper
from warmlink.orchestration.master.algorithms.structure import feedthrough_order
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.slaves.network import Network


class Explicit(Algorithm):
    """An algorithm that is nothing but its schedule."""

    order: ClassVar[int] = 1

    @abstractmethod
    def schedule(self, network: Network) -> Schedule:
        """How the slaves are stepped."""

    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network."""
        return ScheduledStepper(network, self.schedule(network))


@dataclass(frozen=True)
class Jacobi(Explicit):
    """Step every slave with held inputs, read all outputs, set all inputs.

    An output with direct feedthrough is thus read with the old inputs at the new time, as libcosim's fixed-
    step algorithm and Ecos do it. Where it is `settled`, such outputs are read again after the exchange and
    passed on, so that all values belong to one communication point: three times as accurate on a motor and
    its link.
    """

    settled: bool = False

    def schedule(self, network: Network) -> Schedule:
        """All slaves at once."""
        every = range(len(network.slaves))
        jobs = [(deed, k) for deed in (STEP, READ, WRITE) for k in every]
        if self.settled:
            jobs += [(deed, k) for k in feedthrough_order(network) for deed in (WRITE, READ)]
            jobs += [(WRITE, k) for k in every]
        return Schedule(jobs, at_once=True)


@dataclass(frozen=True)
class GaussSeidel(Explicit):
    """Set a slave's inputs from the newest outputs, step it, read its outputs; then the next.

    The sequence names the slaves in the order of stepping; default: by direct feedthrough.
    """

    sequence: tuple[str, ...] | None = None

    def schedule(self, network: Network) -> Schedule:
        """One slave after the other; InputError where the sequence does not name each once."""
        if self.sequence is not None and sorted(self.sequence) != sorted(network.index):
            raise InputError(
                f"order of slaves: {', '.join(self.sequence)} is not an order of {', '.join(network.index)}; "
                "name each of them once"
            )
        given = [network.index[name] for name in self.sequence or ()]
        order = given or feedthrough_order(network)
        return Schedule([(deed, k) for k in order for deed in (WRITE, STEP, READ)], at_once=False)


class ScheduledStepper(Stepper):
    """Steps one network by a schedule."""

    def __init__(self, network: Network, schedule: Schedule) -> None:
        self.network = network
        exchanges = {READ: network.read, WRITE: network.write}
        self._jobs = [(exchanges.get(deed), k) for deed, k in schedule.jobs]

    def step(self, time: float, step_size: float) -> None:
        """Advance all slaves by one communication step."""
        for exchange, k in self._jobs:
            if exchange is None:
                self.network.step(k, time, step_size)
            else:
                exchange(k)


MASTERS = {
    "jacobi": (Jacobi(), "all slaves step at once with held inputs, as libcosim and Ecos do it"),
    "jacobi_settled": (
        Jacobi(settled=True),
        "Jacobi whose outputs with direct feedthrough are read again after the exchange",
    ),
    "gauss_seidel": (GaussSeidel(), "slaves step one after the other, each with the newest values"),
}
"""Master algorithms by name, and what each does."""

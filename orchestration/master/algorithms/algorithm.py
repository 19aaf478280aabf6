"""The one interface of all master algorithms."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from warmlink.fmus.records import dataclass
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.slaves.network import Network


class Stepper(ABC):
    """An algorithm that is bound to one network, with what it remembers from step to step.

    Its remarks say what these slaves do not allow, and what is done instead.
    """

    remarks: tuple[str, ...] = ()

    @abstractmethod
    def step(self, time: float, step_size: float) -> None:
        """Advance all slaves from `time` to `time + step_size` (s) and exchange their values.

        Before the first step every output has been read and every input set. SlaveError where a slave fails
        or a value is not finite.
        """

    def memory(self) -> object:
        """Return, as JSON can hold it, what a later continuation needs besides the slaves' states."""
        return None

    def recall(self, memory: object) -> None:  # noqa: B027
        """Restore what `memory` returned."""

    def disturb(self) -> None:  # noqa: B027
        """Forget what says nothing of the next step, before which a parameter has changed."""


@dataclass(frozen=True)
class Schedule:
    """Order of work in a communication step that steps each slave once, with inputs that are known already.

    The slaves in the order of stepping: `at_once`, before any value is exchanged, else each value is handed
    on as soon as it is there. Those `again` are read once more after the exchange, which no compiled loop
    does.
    """

    slaves: tuple[int, ...]
    at_once: bool
    again: tuple[int, ...] = ()


class Algorithm(ABC):
    """A master algorithm, as chosen by a user; it does nothing until it is bound to a network.

    Some do by themselves what `Retry` does around others: `repeats_steps` in parts that a slave discards.
    """

    repeats_steps: ClassVar[bool] = False

    @property
    @abstractmethod
    def order(self) -> int:
        """Order of convergence of the coupling error in the communication step size."""

    def schedule(self, network: Network) -> Schedule | None:
        """How the slaves are stepped where that is so; too long a step may then be unstable."""
        return None

    @abstractmethod
    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network and run; InputError where the slaves cannot do what the algorithm needs."""

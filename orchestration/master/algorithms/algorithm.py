"""The one interface of all master algorithms."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

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


STEP, READ, WRITE = range(3)
"""What is done with a slave: it is stepped, its outputs are read, its inputs are written."""


@dataclass(frozen=True)
class Schedule:
    """Order of work in a communication step that steps each slave once, with inputs that are known already.

    The `jobs` say what is done with which slave; `at_once` is whether all step before any value is exchanged.
    """

    jobs: Sequence[tuple[int, int]]
    at_once: bool


class Algorithm(ABC):
    """A master algorithm, as chosen by a user; it does nothing until it is bound to a network."""

    @property
    @abstractmethod
    def order(self) -> int:
        """Order of convergence of the coupling error in the communication step size."""

    @property
    def goes_back(self) -> bool:
        """Whether a state of before the present communication point may be restored; slaves are told.

        An algorithm that repeats a step from its beginning does not go back in this sense.
        """
        return False

    def schedule(self, network: Network) -> Schedule | None:
        """How the slaves are stepped where that is so; too long a step may then be unstable."""
        return None

    def at_half_the_step(self) -> Algorithm:
        """The same for a run with half the communication step, whose error is smaller as the order says."""
        return self

    @abstractmethod
    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network and run; InputError where the slaves cannot do what the algorithm needs."""

"""The one interface of all master algorithms."""

from __future__ import annotations

from typing import Protocol

from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.network import Network


class Stepper(Protocol):
    """An algorithm at work on one network: it remembers what it needs from step to step.

    Attributes
    ----------
    remarks : tuple of str
        Sentences on what these slaves do not allow, and what is done instead.
    """

    @property
    def remarks(self) -> tuple[str, ...]: ...  # noqa: D102

    def step(self, time: float, step_size: float) -> None:
        """Advance all slaves from `time` to `time + step_size` (s) and exchange their values.

        Before the first step every output has been read and every input set.

        Raises
        ------
        SlaveError
            Where a slave fails or a value is not finite.
        """

    def memory(self) -> object:
        """Give what must be kept beside the slaves' states for a later continuation; may be pickled."""

    def recall(self, memory: object) -> None:
        """Take what `memory` gave."""


class Algorithm(Protocol):
    """A master algorithm, as chosen by a user; it does nothing until it is bound to a network."""

    @property
    def order(self) -> int:
        """Order of convergence of the coupling error in the communication step size."""

    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network and the communication points of one run.

        Raises
        ------
        InputError
            Where the slaves cannot do what the algorithm needs.
        """


class Memoryless:
    """A stepper that needs nothing from earlier steps and has nothing to remark."""

    remarks: tuple[str, ...] = ()

    def memory(self) -> object:
        """Give nothing."""
        return None

    def recall(self, memory: object) -> None:
        """Take nothing."""

"""Parameters that change during the run, around any other algorithm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Stepper
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.system.check import checked_value
from warmlink.orchestration.system.model import Value


@dataclass(frozen=True)
class Change:
    """From a time in s on, a tunable parameter has another value, in its own unit."""

    time: float
    slave: str
    parameter: str
    value: Value


@dataclass(frozen=True)
class Retuned(Algorithm):
    """Change tunable parameters at communication points, then step as the inner algorithm does.

    A change between two communication points acts from the later one on. InputError if a change is of
    something else than a tunable parameter, or its value does not fit.
    """

    inner: Algorithm
    changes: tuple[Change, ...]

    @property
    def order(self) -> int:
        """Order of convergence of the inner algorithm."""
        return self.inner.order

    @property
    def goes_back(self) -> bool:
        """Whether the inner algorithm does."""
        return self.inner.goes_back

    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network."""
        for change in self.changes:
            where = f"{change.slave}.{change.parameter}"
            k, name = network.locate(where)
            variable = network.slaves[k].variables[name]
            if variable.variability != "tunable":
                raise InputError(f"{where}: is {variable.variability}, not tunable; set it before the run")
            checked_value(variable, change.value, where)
        return TunedStepper(self.inner.bind(network, points), network, self.changes)


class TunedStepper(Stepper):
    """The inner stepper, which applies the parameter changes that are due before each step.

    They are set anew in every step, because a step that is repeated starts from a state that holds the
    parameters of an earlier time.
    """

    def __init__(self, inner: Stepper, network: Network, changes: tuple[Change, ...]) -> None:
        self.inner, self.remarks = inner, inner.remarks
        self._network = network
        self._changes = sorted(changes, key=lambda change: change.time)
        self._changed = 0

    def step(self, time: float, step_size: float) -> None:
        """Change what is due, then step."""
        due = [change for change in self._changes if change.time <= time + 1e-9 * step_size]
        if len(due) != self._changed:
            self._changed = len(due)
            self.inner.disturb()
        for each in due:
            self._network.slaves[self._network.index[each.slave]].set((each.parameter,), (each.value,))
        self.inner.step(time, step_size)

    def memory(self) -> object:
        """Return how many changes were made, and what the inner stepper remembers."""
        return self._changed, self.inner.memory()

    def recall(self, memory: object) -> None:
        """Take what `memory` gave."""
        self._changed, carried = cast("tuple[int, object]", memory)
        self.inner.recall(carried)

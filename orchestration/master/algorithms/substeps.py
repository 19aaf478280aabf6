"""Communication steps in parts: binary fractions of the macro step, so that times stay exact."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar, cast

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.algorithm import Stepper, StepperAround
from warmlink.orchestration.master.algorithms.signals import switching_outputs
from warmlink.orchestration.master.slaves.network import Network, Snapshot
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.system.model import Value

REPEATABLE = ("discard", "not converged")
DEEPEST = 40


def halvings(step_size: float, minimum_step: float) -> int:
    """Tell how often a step may be halved without falling below a minimum, both in s."""
    if not 0 < minimum_step <= step_size:
        raise InputError(
            f"minimum step: {minimum_step:g} s is not above 0 s and at most the communication step size "
            f"{step_size:g} s; choose one between"
        )
    return min(DEEPEST, math.floor(math.log2(step_size / minimum_step) + 1e-9))


def refuse_unless_repeatable(network: Network, purpose: str) -> None:
    """Refuse, by name, slaves that cannot repeat a step with another size."""
    stuck = network.unable_to_restore()
    rigid = [s.name for s in network.slaves if not s.capabilities.variable_step]
    if stuck or rigid:
        why = (
            f"cannot restore its state, which {purpose} needs to repeat a step"
            if stuck
            else f"takes steps of one size only, so {purpose} cannot change them"
        )
        raise InputError(f"{', '.join(stuck or rigid)}: {why}; choose a fixed step")


class SubSteps(StepperAround):
    """Covers each macro step with parts whose size follows an error estimate.

    Parameters
    ----------
    network : Network
        All slaves restore their state.
    inner : Stepper
        Does the parts.
    levels : int
        The smallest part is the macro step over 2**levels.
    growth : float
        The next part is doubled where the estimate is below this fraction of what is allowed.
    """

    def __init__(self, network: Network, inner: Stepper, levels: int, growth: float) -> None:
        super().__init__(inner)
        self.network = network
        self._ticks = 1 << levels
        self._size = self._ticks
        self._growth = growth
        self._before: Snapshot | None = None
        self._switching = switching_outputs(network)
        self._held, self._last = list[Value](), False

    locates_jumps: ClassVar[bool] = True

    @abstractmethod
    def attempt(self, time: float, step_size: float) -> float:
        """Advance by a part; give the estimated error as a fraction of what is allowed."""

    def step(self, time: float, step_size: float) -> None:
        """Advance all slaves by one communication step, in as many parts as it needs."""
        position, size = 0, self._size
        while position < self._ticks:
            while position % size:
                size //= 2
            part = step_size * (size / self._ticks)
            error = self._try(time + step_size * (position / self._ticks), part, last=size == 1)
            if error > 1.0:
                size //= 2
                continue
            position += size
            if error < self._growth:
                size = min(2 * size, self._ticks)
        self._size = size

    def memory(self) -> object:
        """Give the size reached and the inner stepper's memory."""
        return self._size, super().memory()

    def recall(self, memory: object) -> None:
        """Take what `memory` gave."""
        self._size, carried = cast("tuple[int, object]", memory)
        super().recall(carried)

    @property
    def too_long(self) -> bool:
        """Whether there was a jump in the part just tried, which is not the smallest.

        A comparison of results does not see it: parts are halved until it is caught in the smallest, whose
        length then bounds how late it is seen.
        """
        return not self._last and self._held != self._switches()

    def _switches(self) -> list[Value]:
        return [self.network.outputs[k][position] for k, position in self._switching]

    def back(self, snapshot: Snapshot, memory: object) -> None:
        """Undo a part."""
        self.network.rewind(snapshot)
        self.inner.recall(memory)

    def _try(self, time: float, part: float, *, last: bool) -> float:
        self._before = self.network.snapshot(reuse=self._before)
        memory = self.inner.memory()
        self._held, self._last = self._switches(), last
        try:
            error = self.attempt(time, part)
            if self.locates_jumps and self._held != self._switches():
                error = 1.0 if last else math.inf
        except SlaveError as failure:
            if failure.status not in REPEATABLE:
                raise
            if last:
                raise failure.because(f"smaller steps were tried, down to {part:g} s") from failure
            error = math.inf
        if error > 1.0:
            if last:
                raise SlaveError(
                    self.network.slaves[0].name,
                    "not converged",
                    time,
                    f"with the smallest step of {part:g} s the estimated error is still {error:.3g} times "
                    "what is allowed; allow more, or a smaller minimum step",
                )
            self.back(self._before, memory)
            self.network.rejected += 1
        return error

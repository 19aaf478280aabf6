"""Communication steps in parts: smaller after a discard, or as an estimate of the error asks.

Parts are binary fractions of the macro step, so that times stay exact.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass, field
from typing import ClassVar, cast

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Schedule, Stepper
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.slaves.network import Network, SlaveStates
from warmlink.orchestration.master.slaves.slave import SlaveError

REPEATABLE = ("discard", "not converged")
DEEPEST = 40  # halvings
# Copies are made ever more seldom while nothing is discarded: of Python FMUs they cost several steps.
FIRST_KEYFRAME_STEPS, LAST_KEYFRAME_STEPS = 64, 4096
CAREFUL_STEPS = 16


@dataclass(frozen=True)
class InParts(Algorithm):
    """Has `inner` do a step, or parts of it of `minimum_step` s or more (default: 1/1024 of it)."""

    inner: Algorithm
    minimum_step: float | None = field(default=None, kw_only=True)

    @property
    def order(self) -> int:
        """Order of convergence of the inner algorithm."""
        return self.inner.order

    @property
    def goes_back(self) -> bool:
        """Parts that were done are undone with the one after them."""
        return True


class PartsStepper(Stepper):
    """Covers each macro step with parts whose size follows an error estimate.

    The next part is doubled where the estimate is below the fraction `growth` of what is allowed. All slaves
    must restore their state.
    """

    remembered: ClassVar[tuple[str, ...]] = ("_size",)

    def __init__(self, network: Network, chosen: InParts, points: CommunicationPoints, growth: float) -> None:
        self.inner = chosen.inner.bind(network, points)
        self.remarks = self.inner.remarks
        smallest = points.step_size / 1024 if chosen.minimum_step is None else chosen.minimum_step
        if not 0 < smallest <= points.step_size:
            raise InputError(
                f"minimum step: {smallest:g} s is not above 0 s and at most the communication step size "
                f"{points.step_size:g} s; choose one between"
            )
        self.network = network
        self._ticks = 1 << min(DEEPEST, math.floor(math.log2(points.step_size / smallest) + 1e-9))
        self._size = self._ticks
        self._growth = growth
        self._kept: tuple[SlaveStates, object] | None = None
        self.in_the_way = ""

    @abstractmethod
    def attempt(self, time: float, step_size: float, *, last: bool) -> float:
        """Advance by a part; give the estimated error as a fraction of what is allowed.

        The state before is kept; the `last` part is the smallest. Where it is more than allowed, `in_the_way`
        is the slave of whose variable it is.
        """

    def keep(self) -> None:
        """Copy the present state, over the copy made before."""
        reuse = None if self._kept is None else self._kept[0]
        self._kept = self.network.snapshot(reuse=reuse), self.inner.memory()

    def back(self) -> None:
        """Return to the copy."""
        assert self._kept is not None
        self.network.rewind(self._kept[0])
        self.inner.recall(self._kept[1])

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
            end = self.network.end()
            if end is not None and position < self._ticks:
                raise end
            if error < self._growth:
                size = min(2 * size, self._ticks)
        self._size = size

    def memory(self) -> object:
        """Give what decides how the next parts are done."""
        return {name: getattr(self, name) for name in self.remembered}, self.inner.memory()

    def recall(self, memory: object) -> None:
        """Take what `memory` gave; copies of states are from long ago then."""
        own, carried = cast("tuple[dict[str, object], object]", memory)
        vars(self).update(own)
        self._kept = None
        self.inner.recall(carried)

    def _try(self, time: float, part: float, *, last: bool) -> float:
        self.keep()
        try:
            error = self.attempt(time, part, last=last)
        except SlaveError as failure:
            if failure.status not in REPEATABLE:
                raise
            if last:
                raise failure.because(f"smaller steps were tried, down to {part:g} s") from failure
            error, self.in_the_way = math.inf, failure.slave
        if error > 1.0 and last:
            told = (
                f"with the smallest step of {part:g} s the estimated error is still {error:.3g} times "
                "what is allowed; allow more, or take smaller communication steps"
            )
            raise SlaveError(self.in_the_way, "not converged", time, told)
        if error > 1.0:
            self.back()
            self.network.rejected[self.in_the_way] += 1
        return error


@dataclass(frozen=True)
class Retry(InParts):
    """Repeat a discarded step in halves, quarters and so on, down to a minimum.

    Where it may not go `back`, a discarded step ends the run, which can then be begun anew with one that may.
    """

    back: bool = field(default=True, kw_only=True, repr=False)

    @property
    def goes_back(self) -> bool:
        """A discarded step is one of many since the last copy, which are then done again."""
        return self.back or self.inner.goes_back

    def schedule(self, network: Network) -> Schedule | None:
        """That of the inner algorithm, as long as nothing is discarded."""
        return self.inner.schedule(network)

    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network."""
        return RetryStepper(network, self, points)


class RetryStepper(PartsStepper):
    """Steps with keyframes to go back to.

    A slave that answers discard leaves the others already stepped, so all must go back to where the step
    began. To copy every state before every step would cost more than most steps; instead a copy is made now
    and then, and after a discard the steps since are done again, which gives the same values bit for bit.
    """

    remembered = ("_size", "_careful")

    def __init__(self, network: Network, chosen: Retry, points: CommunicationPoints) -> None:
        super().__init__(network, chosen, points, growth=-1.0)
        self._since: list[tuple[float, float]] = []
        self._interval = FIRST_KEYFRAME_STEPS
        self._careful = 0
        self._stuck = ", ".join(dict.fromkeys((*network.unable_to_restore(), *network.of_one_step())))
        self._copies = chosen.back and not self._stuck

    def attempt(self, time: float, step_size: float, *, last: bool) -> float:
        """Step; where that is not discarded, nothing was wrong with it."""
        self.inner.step(time, step_size)
        return 0.0

    def step(self, time: float, step_size: float) -> None:
        """Advance by one communication step, in parts after a discard."""
        if self._careful:
            self._careful -= 1  # the parts keep their size until it is time to try a whole step
            self._in_parts(time, step_size)
            return
        if self._copies and (self._kept is None or len(self._since) >= self._interval):
            self._interval = min(2 * self._interval, LAST_KEYFRAME_STEPS)
            self._since = []
            self.keep()
        try:
            self.inner.step(time, step_size)
        except SlaveError as failure:
            if failure.status not in REPEATABLE:
                raise
            if self._stuck:
                told = f"{self._stuck} cannot restore its state or change its step"
                raise failure.because(f"no smaller step could be tried, for {told}") from failure
            if self._ticks == 1 or not self._copies:
                raise
            self.back()
            for earlier in self._since:
                self.inner.step(*earlier)
            self.network.rejected[failure.slave] += 1
            self._size, self._careful = self._ticks // 2, CAREFUL_STEPS
            self._in_parts(time, step_size)
            return
        if self._copies:
            self._since.append((time, step_size))

    def _in_parts(self, time: float, step_size: float) -> None:
        super().step(time, step_size)
        if not self._careful:
            self._size = self._ticks
        # Steps done in parts are not replayed: a new keyframe follows.
        self._interval = FIRST_KEYFRAME_STEPS
        self._since = [(time, step_size)] * self._interval

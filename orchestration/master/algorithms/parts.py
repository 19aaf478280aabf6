"""Communication steps in parts: smaller after a discard, or as small as an estimate of the error asks.

Parts are binary fractions of the macro step, so that times stay exact.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import field
from typing import ClassVar, cast

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.fmus.records import dataclass
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Schedule, Stepper
from warmlink.orchestration.master.algorithms.structure import continuous_inputs, switching_outputs
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.slaves.network import Network, Snapshot
from warmlink.orchestration.master.slaves.slave import SlaveError, nominal
from warmlink.orchestration.system.model import Value

REPEATABLE = ("discard", "not converged")
DEEPEST = 40  # halvings
SHARE_OF_NOMINAL = 1e-6
# Copies are made ever more seldom while nothing is discarded: of Python FMUs they cost several steps.
FIRST_KEYFRAME_STEPS, LAST_KEYFRAME_STEPS = 64, 4096
CAREFUL_STEPS = 16
# How many parts follow a comparison without one of their own, and how much longer than that one's.
MOST_TRUSTED, LONGER = 8, 4.0


@dataclass(frozen=True)
class InParts(Algorithm):
    """Has `inner` do a step, or parts of it of `minimum_step` s or more (default: 1/1024 of it)."""

    inner: Algorithm
    minimum_step: float | None = field(default=None, kw_only=True)
    repeats_steps: ClassVar[bool] = True

    @property
    def order(self) -> int:
        """Order of convergence of the inner algorithm."""
        return self.inner.order


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
        self._kept: tuple[Snapshot, object] | None = None

    @abstractmethod
    def attempt(self, time: float, step_size: float, *, last: bool) -> float:
        """Advance by a part; give the estimated error as a fraction of what is allowed.

        The state before is kept; the `last` part is the smallest.
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
            error = math.inf
        if error > 1.0 and last:
            told = (
                f"with the smallest step of {part:g} s the estimated error is still {error:.3g} times "
                "what is allowed; allow more, or a smaller minimum step"
            )
            raise SlaveError(self.network.slaves[0].name, "not converged", time, told)
        if error > 1.0:
            self.back()
            self.network.rejected += 1
        return error


@dataclass(frozen=True)
class Retry(InParts):
    """Repeat a discarded step in halves, quarters and so on, down to a minimum."""

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
        if not self._stuck and (self._kept is None or len(self._since) >= self._interval):
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
            if self._ticks == 1:
                raise
            self.back()
            for earlier in self._since:
                self.inner.step(*earlier)
            self.network.rejected += 1
            self._size, self._careful = self._ticks // 2, CAREFUL_STEPS
            self._in_parts(time, step_size)
            return
        if not self._stuck:
            self._since.append((time, step_size))

    def _in_parts(self, time: float, step_size: float) -> None:
        super().step(time, step_size)
        if not self._careful:
            self._size = self._ticks
        # Steps done in parts are not replayed: a new keyframe follows.
        self._interval = FIRST_KEYFRAME_STEPS
        self._since = [(time, step_size)] * self._interval


@dataclass(frozen=True)
class StepDoubling(InParts):
    """Keep the coupling error of chosen variables within tolerances over the whole run.

    Each part is done in one step and in two. The results differ by (2**p - 1) times the error of the finer
    one, p being the order of the inner algorithm (Richardson). The finer one is kept where that error is at
    most the tolerance's share of the part in the run's duration; else the part is halved and repeated. Errors
    that do not grow by themselves then stay below the tolerance at the end.

    Parameters
    ----------
    tolerances : mapping, optional
        Largest error by `slave.variable`, in that variable's unit; default: 1e-6 of the nominal value for
        every continuous signal that is exchanged.
    """

    tolerances: Mapping[str, float] | None = None

    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network, whose slaves must all be able to repeat steps."""
        reason = "cannot restore its state, which step doubling needs to repeat a step"
        unable = network.unable_to_restore()
        if not unable:
            reason = "takes steps of one size only, so step doubling cannot change them"
            unable = network.of_one_step()
        if unable:
            raise InputError(f"{', '.join(unable)}: {reason}; choose a fixed step")
        return DoublingStepper(network, self, points)


class DoublingStepper(PartsStepper):
    """Step doubling on one network.

    Two steps beside the one are two thirds of the work. Where the last comparison says that the next part,
    done in one step, will be far within what is allowed, it is done so, at most `MOST_TRUSTED` times in turn.
    """

    remembered = ("_size", "_compared", "_trusted")

    def __init__(self, network: Network, chosen: StepDoubling, points: CommunicationPoints) -> None:
        self._order = chosen.inner.order
        super().__init__(network, chosen, points, growth=0.5 ** (self._order + 2))
        self._duration = points.stop_time - points.start_time
        tolerances = _exchanged(network) if chosen.tolerances is None else chosen.tolerances
        self._places = [network.locate(name) for name in tolerances]
        self._tolerances = np.array(list(tolerances.values()))
        self._switching = switching_outputs(network)
        self._compared = 0.0, 0.0  # length in s of the last part that was compared, and its error
        self._trusted = MOST_TRUSTED

    def attempt(self, time: float, step_size: float, *, last: bool) -> float:
        """Step once; unless that is known to do, go back, step twice, compare.

        A comparison does not see a jump: parts are halved until it is caught in the smallest, whose length
        then bounds how late it is seen.
        """
        held = self._switches()
        self.inner.step(time, step_size)
        if held != self._switches() and not last:
            return math.inf
        expected = self._expected(step_size)
        if expected < self._growth and held == self._switches():
            self._trusted += 1
            return expected
        coarse = self._values()
        self.back()
        self.inner.step(time, step_size / 2)
        self.inner.step(time + step_size / 2, step_size / 2)
        self._trusted = 0
        if held != self._switches():
            self._compared = 0.0, 0.0
            return 1.0 if last else math.inf
        allowed = self._tolerances * (step_size / self._duration)
        share = float(2**self._order - 1)
        error = float(np.max(np.abs(self._values() - coarse) / share / allowed, initial=0.0))
        self._compared = step_size, error
        return error

    def _expected(self, step_size: float) -> float:
        """Estimate the error of one step by the last comparison; infinite where that says nothing of it."""
        length, error = self._compared
        if self._trusted >= MOST_TRUSTED or step_size > LONGER * length:
            return math.inf
        return error * (2.0 * step_size / length) ** self._order

    def _switches(self) -> list[Value]:
        return [self.network.outputs[k][position] for k, position in self._switching]

    def _values(self) -> Array:
        return np.array([self.network.slaves[k].get((name,))[0] for k, name in self._places], float)


def _exchanged(network: Network) -> dict[str, float]:
    """Give a tolerance for every continuous signal that is exchanged."""
    sources = {
        f"{network.slaves[wire.slave].name}.{network.source(wire).name}": network.source(wire)
        for k in range(len(network.slaves))
        for wire in (network.wires[k][position] for position in continuous_inputs(network, k))
    }
    return {name: SHARE_OF_NOMINAL * nominal(source) for name, source in sources.items()}

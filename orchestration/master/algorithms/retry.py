"""Discarded steps are repeated in smaller parts.

A slave that answers discard leaves the others already stepped, so all must go back to where the step
began. To copy every state before every step would cost more than most steps; instead a copy is made now
and then, and after a discard the steps since are done again, which gives the same values bit for bit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, cast

from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Around, Stepper
from warmlink.orchestration.master.algorithms.substeps import REPEATABLE, SubSteps, halvings
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.slaves.network import Network, Snapshot
from warmlink.orchestration.master.slaves.slave import SlaveError

# Copies are made ever more seldom while nothing is discarded: of Python FMUs they cost several steps.
FIRST_KEYFRAME_STEPS, LAST_KEYFRAME_STEPS = 64, 4096
CAREFUL_STEPS = 16


@dataclass(frozen=True)
class Retry(Around):
    """Repeat a discarded step in halves, quarters and so on, down to a minimum.

    Parameters
    ----------
    minimum_step : float, optional
        In s; default: 1/1024 of the communication step size.
    """

    minimum_step: float | None = None
    repeats_steps: ClassVar[bool] = True

    @property
    def whole_steps(self) -> Algorithm:
        """The inner algorithm."""
        return self.inner

    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network."""
        smallest = points.step_size / 1024 if self.minimum_step is None else self.minimum_step
        levels = halvings(points.step_size, smallest)
        return RetryStepper(network, self.inner.bind(network, points), levels)


class RetryStepper(SubSteps):
    """Steps with keyframes to go back to."""

    locates_jumps: ClassVar[bool] = False

    def __init__(self, network: Network, inner: Stepper, levels: int) -> None:
        super().__init__(network, inner, levels, growth=-1.0)
        self._keyframe: tuple[Snapshot, object] | None = None
        self._since: list[tuple[float, float]] = []
        self._interval = FIRST_KEYFRAME_STEPS
        self._careful = 0
        rigid = [s.name for s in network.slaves if not s.capabilities.variable_step]
        self._stuck = ", ".join(dict.fromkeys((*network.unable_to_restore(), *rigid)))

    def attempt(self, time: float, step_size: float) -> float:
        """Step; where that is not discarded, nothing was wrong with it."""
        self.inner.step(time, step_size)
        return 0.0

    def step(self, time: float, step_size: float) -> None:
        """Advance by one communication step, in parts after a discard."""
        if self._careful:
            self._careful -= 1  # the parts keep their size until it is time to try a whole step
            self._in_parts(time, step_size)
            return
        if not self._stuck and (self._keyframe is None or len(self._since) >= self._interval):
            reuse = None if self._keyframe is None else self._keyframe[0]
            self._interval = min(2 * self._interval, LAST_KEYFRAME_STEPS)
            self._keyframe = (self.network.snapshot(reuse=reuse), self.inner.memory())
            self._since = []
        try:
            self.inner.step(time, step_size)
        except SlaveError as failure:
            if failure.status not in REPEATABLE:
                raise
            if self._keyframe is None:
                raise failure.because(
                    f"no smaller step could be tried, for {self._stuck} cannot restore its state or change "
                    "its step"
                ) from failure
            if self._ticks == 1:
                raise
            self.back(*self._keyframe)
            for earlier in self._since:
                self.inner.step(*earlier)
            self.network.rejected += 1
            self._size = self._ticks // 2
            self._careful = CAREFUL_STEPS
            self._in_parts(time, step_size)
            return
        if self._keyframe is not None:
            self._since.append((time, step_size))

    def memory(self) -> object:
        """Give what decides how the next steps are done."""
        return self._careful, super().memory()

    def recall(self, memory: object) -> None:
        """Take what `memory` gave; the next step makes a keyframe."""
        self._careful, carried = cast("tuple[int, object]", memory)
        self._keyframe, self._since = None, []
        super().recall(carried)

    def _in_parts(self, time: float, step_size: float) -> None:
        super().step(time, step_size)
        if not self._careful:
            self._size = self._ticks
        # Steps done in parts are not replayed: a new keyframe follows.
        self._interval = FIRST_KEYFRAME_STEPS
        self._since = [(time, step_size)] * self._interval

"""Step doubling: parts of a communication step that are as small as an estimate of the error asks."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.master.algorithms import ERROR_CONTROLLED
from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Stepper
from warmlink.orchestration.master.algorithms.iterated import InterfaceNewton
from warmlink.orchestration.master.algorithms.parts import InParts, PartsStepper
from warmlink.orchestration.master.algorithms.structure import exchanged
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.master.slaves.slave import nominal
from warmlink.orchestration.system.model import Value

SHARE_OF_NOMINAL = 1e-6
# How many parts follow a comparison without one of their own, how much longer than that one's, and how much
# more the variables may bend in them.
MOST_TRUSTED, LONGER, MORE_BENT = 8, 4.0, 2.0
LOPSIDED = 100.0
"""How many times as far a signal that leaps moves in one half of the smallest part as in the other."""

ROUNDING = 1e-9
"""Of a signal's value; what moves by less does not leap."""


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
    share : float, optional
        What of the tolerances is allowed.
    """

    tolerances: Mapping[str, float] | None = None
    share: float = field(default=1.0, kw_only=True)

    def at_half_the_step(self) -> Algorithm:
        """The steps follow the error, so that it is smaller where less of it is allowed."""
        return replace(self, share=self.share * 0.5**self.order)

    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network, whose slaves must all be able to repeat steps."""
        reason = "cannot restore its state, which step doubling needs to repeat a step"
        unable = network.unable_to_restore()
        if not unable:
            reason = "takes steps of one size only, so step doubling cannot change them"
            unable = network.of_one_step()
        if unable:
            raise InputError(f"{', '.join(unable)}: {reason}; choose a fixed step")
        for name, tolerance in (self.tolerances or {}).items():
            if not tolerance * self.share > 0:
                raise InputError(f"tolerance of {name}: {tolerance * self.share:g} is not above 0; give more")
        return DoublingStepper(network, self, points)


class DoublingStepper(PartsStepper):
    """Step doubling on one network.

    Two steps beside the one are two thirds of the work. Where the last comparison says that the next part,
    done in one step, will be far within what is allowed, it is done so, at most `MOST_TRUSTED` times in turn,
    and as long as the variables do not bend more than they did then, as where something begins to move.
    """

    remembered = ("_size", "_compared", "_trusted", "_before", "_still")

    def __init__(self, network: Network, chosen: StepDoubling, points: CommunicationPoints) -> None:
        self._order = chosen.inner.order
        super().__init__(network, chosen, points, growth=0.5 ** (self._order + 2))
        tolerances = _exchanged(network) if chosen.tolerances is None else chosen.tolerances
        self._places = [network.locate(name) for name in tolerances]
        # Errors that the variables may grow by in each second.
        allowed = chosen.share * np.array(list(tolerances.values()))
        self._allowed = allowed / (points.stop_time - points.start_time)
        self._smooth, switching = exchanged(network)
        schedule = chosen.inner.schedule(network)
        # Where all inputs are held, it shows only in the next step that something begins to move.
        moving = self._smooth if schedule is not None and schedule.at_once else ()
        self._watched, self._switching = (*switching, *moving), len(switching)
        self._still = [True] * self._switching  # those that stood still in the part before, or may not move
        self._trusted = MOST_TRUSTED
        self._forget()

    def _forget(self) -> None:
        """Compare the next part, whatever the last comparison said."""
        self._compared = 0.0, 0.0, 0.0  # of the last part compared: length in s, error, bend for each second
        self._before: tuple[float, list[float]] = 0.0, []  # of the part before: length in s, rates of change

    def attempt(self, time: float, step_size: float, *, last: bool) -> float:
        """Step once; unless that is known to do, go back, step twice, compare.

        A comparison does not see a jump: parts are halved until it is caught in the smallest, whose length
        then bounds how late it is seen. What was declared continuous and jumps is known by then.
        """
        sent, start = self._sent(self._watched), self._values()

        def jumped() -> str | None:
            """A slave with a signal that jumped."""
            moved = zip(self._watched, self._still, sent, self._sent(self._watched), strict=False)
            leapt = (k for (k, _), still, old, new in moved if still and old is not new and old != new)
            return next((self.network.slaves[k].name for k in leapt), None)

        self.inner.step(time, step_size)
        sudden, end = jumped(), self._values()
        if sudden and not last:
            self.in_the_way = sudden
            return math.inf
        # From rates that are not known nothing bends, so that a second comparison follows the first one.
        bend = self._share((end - start) / step_size - np.array(self._before[1] or np.nan))
        error = self._expected(step_size, bend)
        if error < self._growth and not sudden:
            self._trusted += 1
        else:
            self.back()
            courses = [self._sent(self._smooth)]
            for half in (time, time + step_size / 2):
                self.inner.step(half, step_size / 2)
                courses.append(self._sent(self._smooth))
            coarse, end = end, self._values()
            rates = (end - coarse) / step_size
            error = self._share(rates) / (2**self._order - 1)
            worst = int(np.argmax(np.nan_to_num(np.abs(rates) / self._allowed))) if rates.size else None
            sudden = jumped()
            self.in_the_way = sudden or (
                "" if worst is None else self.network.slaves[self._places[worst][0]].name
            )
            if last and error > 1.0 and _leapt(courses):
                sudden = self.in_the_way
            self._trusted, self._compared = 0, (step_size, error, bend / (self._before[0] + step_size))
        if sudden:
            self._forget()
            error = 1.0 if last else math.inf
        elif error <= 1.0:
            self._before = step_size, ((end - start) / step_size).tolist()
        if error <= 1.0:
            moved = enumerate(zip(sent, self._sent(self._watched), strict=True))
            self._still = [i < self._switching or old == new for i, (old, new) in moved]
        return error

    def _share(self, rates: Array) -> float:
        """Largest of the known rates of change, as a share of those at which errors may grow."""
        return float(np.fmax.reduce(np.abs(rates) / self._allowed, initial=0.0))

    def _expected(self, step_size: float, bend: float) -> float:
        """Estimate the error of one step by the last comparison; infinite where that says nothing of it."""
        length, error, bent = self._compared
        most = max(self._growth, MORE_BENT * bent * (self._before[0] + step_size))
        if self._trusted >= MOST_TRUSTED or step_size > LONGER * length or bend > most:
            return math.inf
        return error * (2.0 * step_size / length) ** self._order

    def _sent(self, places: Sequence[tuple[int, int]]) -> list[Value]:
        return [self.network.outputs[k][position] for k, position in places]

    def _values(self) -> Array:
        return np.array([self.network.slaves[k].get((name,))[0] for k, name in self._places], float)


def _leapt(courses: Sequence[Sequence[Value]]) -> bool:
    """Whether a signal moves in one half of a part and hardly in the other, at its start, middle and end."""
    values = np.array(courses, dtype=float)
    moved = np.abs(np.diff(values, axis=0))
    least = np.maximum(LOPSIDED * moved.min(axis=0), ROUNDING * np.abs(values).max(axis=0))
    return bool(np.any(moved.max(axis=0) > least))


def _exchanged(network: Network) -> dict[str, float]:
    """Give a tolerance for every continuous signal that is exchanged."""
    sources = {
        f"{network.slaves[k].name}.{network.reads[k][p]}": network.slaves[k].variables[network.reads[k][p]]
        for k, p in exchanged(network)[0]
    }
    return {name: SHARE_OF_NOMINAL * nominal(source) for name, source in sources.items()}


MASTERS = {
    ERROR_CONTROLLED: (
        StepDoubling(InterfaceNewton()),
        "interface Newton in parts of a step, as small as an estimate of the coupling error asks",
    )
}
"""Master algorithms by name, and what each does."""

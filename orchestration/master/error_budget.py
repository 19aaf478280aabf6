"""Whether a communication step is small enough: the bound of the coupling error, and stability.

A run is compared with one that has half its step; after a run, it is checked from a copy of its first state
whether small disturbances die out, so that the check cannot disturb the run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.doubling import StepDoubling
from warmlink.orchestration.master.algorithms.iterated import InterfaceNewton
from warmlink.orchestration.master.algorithms.structure import continuous_inputs
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.recorder import Recorder
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.master.slaves.slave import SlaveError, nominal
from warmlink.orchestration.master.slaves.under_way import SIZE, UnderWay

SAFETY = 1.5
BOLD, TIMID, ATTEMPTS = 100.0, 0.25, 3
"""How many times the tolerances are allowed at first, the share of what would just do that is allowed later,
and how often this is tried."""


Once = Callable[[Algorithm, bool], Result]
"""A run by an algorithm, at the step that was asked for, or at half of it."""

FEW_STEPS, MOST_STEPS = 20, 0.5
"""Half steps that say nothing yet, and the share of the steps that are most of them."""

PROBE_STEPS = 120
DISTURBANCE = 1e-5  # of the nominal values
# What slaves in a row integrate grows with a power of time, a thermal runaway slowly: both stay below.
GROWS_FROM = 1.025
# Past this there is no doubt, and the numbers would soon overflow.
ENOUGH = 1e8
# Of nominal values.
BEYOND_BOUNDS = 1e100


@dataclass(frozen=True)
class Attempt:
    """A run by an algorithm, and its bounded coupling errors.

    Attributes
    ----------
    bounds : by variable, in its unit; none where there was no second run, infinite where that ended early
    broken : why the run at half the step, or a later attempt, was interrupted; None if none was
    missed : variables whose bounds exceed their tolerances
    unseen : variables whose bounds may be too small, see `unseen_in`
    """

    algorithm: Algorithm
    result: Result
    bounds: Mapping[str, float] = field(default_factory=dict)
    broken: str | None = None
    missed: Sequence[str] = ()
    unseen: Sequence[str] = ()

    @property
    def stopped(self) -> str | None:
        """Why one of the two runs ended early, but by a slave that asked for it."""
        return self.result.stopped or self.broken

    def looked_at(self, look: Callable[[Result], Result]) -> Attempt:
        """Give the same with its result looked at, which may end it early; the bounds are then unknown."""
        result = look(self.result)
        if result.stopped == self.result.stopped:
            return replace(self, result=result)
        return replace(self, result=result, bounds=dict.fromkeys(self.bounds, np.inf), broken=None, missed=())

    def with_remarks(self, *remarks: str) -> Attempt:
        """Give the same with more remarks on the result."""
        return replace(self, result=replace(self.result, remarks=(*self.result.remarks, *remarks)))


def attempted(
    algorithm: Algorithm, tolerances: Mapping[str, float], watched: Sequence[str] | None, once: Once
) -> Attempt:
    """Run until the bounds of the coupling errors are within the tolerances, or nothing is left to try.

    SlaveError where the first attempt fails before its first value; a later one that fails or is interrupted
    costs no earlier one.

    Parameters
    ----------
    algorithm : is tried first: its steps all have one size and cost least; then steps that follow the error
    tolerances : by variable, in its unit; empty where a single attempt is to be made
    watched : variables whose errors are bounded; default: all that are recorded
    once : does a run by an algorithm, the second one at half the step
    """
    found: list[Attempt] = []
    for whole in _ways(algorithm, tolerances, found):
        # A later attempt that fails costs no earlier one.
        with suppress(*[SlaveError] * len(found)):
            try:
                result = once(whole, False)
            except InputError as fault:  # the slaves cannot do it
                if not found:
                    raise
                return found[-1].with_remarks(f"no smaller steps were tried: {fault}")
            if found and result.stopped and not found[-1].result.stopped:
                if result.error is not None:
                    continue
                # Ctrl-C, or a full disk
                return replace(found[-1], broken=f"{result.reason} in a run with smaller steps")
            names, bounds, broken = watched or result.table.names, dict[str, float](), None
            unseen: list[str] = []
            if not result.stopped:
                try:
                    fine = once(whole.at_half_the_step(), True)
                    if fine.stopped and fine.error is not None:
                        raise fine.error
                    bounds, broken = coupling_error(result, fine, whole.order, names), fine.stopped
                    before = found[-1].bounds if found else {}
                    # Shorter steps still would be those of an FMU's own again.
                    still = [name for name, bound in bounds.items() if bound == 0.0 < before.get(name, 0.0)]
                    unseen = [*dict.fromkeys([*unseen_in(fine, names), *still])]
                except KeyboardInterrupt:  # before the second run's first value
                    bounds, broken = dict.fromkeys(names, np.inf), "interrupted"
                except SlaveError as fault:
                    bounds = dict.fromkeys(names, np.inf)
                    told = f"the coupling error is not bounded, for the run at half the step failed: {fault}"
                    if tolerances:
                        broken = str(fault)
                    else:
                        result = replace(result, remarks=(*result.remarks, told))
            missed = [name for name, bound in bounds.items() if bound > tolerances.get(name, np.inf)]
            broken = broken and f"{broken} in the run at half the step"
            found.append(Attempt(whole, result, bounds, broken, missed, unseen))
            if broken or not (missed or result.stopped):
                break
    return found[-1]


def _ways(
    algorithm: Algorithm, tolerances: Mapping[str, float], found: Sequence[Attempt]
) -> Iterator[Algorithm]:
    """Give algorithms in the order in which they are tried, by what came of those before.

    The first of those whose steps follow the error allows more than the tolerance, since most errors die out
    again, which step doubling does not count on. The bound then tells how much may be allowed.
    """
    yield algorithm
    share = BOLD
    for _ in range(ATTEMPTS if tolerances else 0):
        following = StepDoubling(InterfaceNewton(tolerance=1e-5), tolerances, share=share)
        yield following
        bounds = found[-1].bounds if found and found[-1].algorithm is following else {}
        share *= TIMID / max([1.0, *(bound / tolerances.get(name, np.inf) for name, bound in bounds.items())])


def coupling_error(coarse: Result, fine: Result, order: int, variables: Sequence[str]) -> dict[str, float]:
    """Bound the largest absolute coupling error of each variable over a run, in its unit (Richardson).

    The fine run has half the communication step size of the coarse one, and may end earlier: the bound then
    holds for that part, in which a warm-up has its largest coupling errors. Where one stopped early, bounds
    are infinite.
    """
    if coarse.stopped or fine.stopped:
        return dict.fromkeys(variables, np.inf)
    factor, found = whole_error(order), {}
    for name in variables:
        both = min(len(coarse[name]), len(fine[name][::2]))  # as a slave may end them
        found[name] = factor * float(np.max(_distances(coarse[name][:both], fine[name][::2][:both])))
    return found


def _distances(one: Array, other: Array) -> Array:
    """Absolute differences; those of integers are exact, though they may not fit into the integers' type."""
    if one.dtype.kind not in "iu":
        return np.abs(one - other)
    larger, smaller = (of(one, other).view(np.uint64) for of in (np.maximum, np.minimum))
    return np.asarray(larger - smaller, dtype=np.float64)


def unseen_in(fine: Result, variables: Sequence[str]) -> list[str]:
    """Variables that move in most steps, but in the run with half the step never in both halves of one.

    What they follow moves in steps of its own, at least as long as those of the run. Half the step then
    brings nothing new: how late they are by a step, the two runs do not show.
    """
    found = []
    for name in variables:
        moved = np.diff(np.asarray(fine[name], dtype=float)) != 0
        first, second = moved[: moved.size // 2 * 2].reshape(-1, 2).T
        if moved.size >= FEW_STEPS and not np.any(first & second) and np.mean(first | second) > MOST_STEPS:
            found.append(name)
    return found


def whole_error(order: int) -> float:
    """Give the bound of a run's error, as a multiple of its distance from the run with half the step.

    Where the algorithm's order of convergence, p, is reached, the two differ by (1 - 2**-p) of the error.
    Jumps in the inputs can lower it to 1; the factor 1.5 covers both.
    """
    return SAFETY / (1.0 - 0.5**order)


def instability(
    name: str,
    network: Network,
    points: CommunicationPoints,
    rewind: Callable[[], None],
    advance: Callable[[Recorder], None],
) -> tuple[str, ...]:
    """Say where a disturbance grows with the steps of an explicit algorithm of that name, and what to do.

    `rewind` goes back to the first of the points in a run that is over, where the slaves are left; `advance`
    steps until a recorder is full.
    """
    factor = _growth(network, points.first(PROBE_STEPS), rewind, advance)
    if factor is None or factor < GROWS_FROM:
        return ()
    return (
        f"{name} is unstable here with steps of {points.step_size:g} s: a disturbance of the exchanged "
        f"values grows {factor:.3g} times in a step; take smaller steps or an iterated algorithm",
    )


def _growth(
    network: Network,
    points: CommunicationPoints,
    rewind: Callable[[], None],
    advance: Callable[[Recorder], None],
) -> float | None:
    """Give the factor by which a disturbance grows from one communication step to the next.

    None where there is nothing to disturb or the probe itself fails.
    """
    wires = (network.wires[k][p] for k in range(len(network.slaves)) for p in continuous_inputs(network, k))
    sources = {(wire.slave, wire.position): network.source(wire) for wire in wires}
    if not sources or points.count < 4:
        return None
    names = [f"{network.slaves[k].name}.{source.name}" for (k, _), source in sources.items()]
    scale = np.array([nominal(source) for source in sources.values()])
    found: list[Array] = []
    overflown = False
    for size in (0.0, DISTURBANCE):
        rewind()
        for sign, ((k, position), of) in enumerate(zip(sources, scale, strict=True)):
            network.outputs[k][position] = float(network.outputs[k][position]) + size * of * (-1) ** sign
        for k in range(len(network.slaves)):
            network.write(k)
        recorder = Recorder(network, names, points, None, None)
        recorder.cells = UnderWay(bytearray(SIZE)).cells  # those of this process tell of the run
        try:
            recorder.take()
            advance(recorder)
        except SlaveError as failure:
            if failure.status != "not finite":
                return None
            overflown = True
        found.append(np.asarray(recorder.table().values)[1:] / scale)
    rewind()
    base, disturbed = found
    # Values that had grown beyond all bounds were unstable; a NaN from nowhere says nothing of the step.
    if overflown and len(base) and float(np.max(np.abs(base[-1]))) > BEYOND_BOUNDS:
        return float("inf")
    common = min(len(base), len(disturbed))
    distances = np.max(np.abs(disturbed[:common] - base[:common]), axis=1, initial=0.0)
    beyond = np.flatnonzero(distances > ENOUGH * DISTURBANCE)
    if beyond.size:
        return float((distances[beyond[0]] / distances[0]) ** (1.0 / max(beyond[0], 1)))
    if overflown or common < points.count:
        return None
    quarter = points.count // 4
    before, after = np.max(distances[-2 * quarter : -quarter]), np.max(distances[-quarter:])
    return float((after / before) ** (1.0 / quarter)) if before > 0 else None

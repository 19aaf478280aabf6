"""Bound of the coupling error: a run is compared with one that has half its communication step."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from warmlink.fmus.records import dataclass
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.iterated import InterfaceNewton
from warmlink.orchestration.master.algorithms.parts import StepDoubling
from warmlink.orchestration.master.recording.result import Result

SAFETY = 1.5
BOLD = (100.0, 10.0, 1.0)


def tried(algorithm: Algorithm, tolerances: Mapping[str, float]) -> Iterator[tuple[Algorithm, Algorithm]]:
    """Give algorithms in the order in which they are tried until the bounds are within the tolerances.

    First the one given, whose steps all have one size and cost least; then steps that follow the error, where
    there are tolerances: by variable, in its unit. Each comes with the one of the run at half the step: where
    the error sets the step, with a tolerance that halves the steps. The first of these allow more than the
    tolerance, since most errors die out again, which step doubling does not count on.
    """
    yield algorithm, algorithm
    inner = InterfaceNewton(tolerance=1e-5)
    for bold in BOLD if tolerances else ():
        following, finer = (
            StepDoubling(inner, {name: share * bold * most for name, most in tolerances.items()})
            for share in (1.0, 0.5**inner.order)
        )
        yield following, finer


@dataclass(frozen=True)
class CouplingError:
    """Bound of the largest absolute coupling error of one variable over a run, in its unit.

    It is infinite where a run did not get to the end; the time in s is when the two runs differ most.
    """

    variable: str
    unit: str | None
    largest: float
    time: float


def coupling_error(
    coarse: Result, fine: Result, order: int, variables: Sequence[str]
) -> tuple[CouplingError, ...]:
    """Bound the coupling error of a run by one with half its step, `fine` (Richardson).

    The difference of the two is (1 - 2**-p) of the coarse run's error where the order p of convergence is
    reached. Jumps in the inputs can lower that to 1: the factor 1.5 covers both. Where the fine run ends
    earlier, the bound holds for that part, in which a warm-up has its largest coupling errors. Both have
    recorded the variables.
    """
    factor = SAFETY / (1.0 - 0.5**order)
    found = []
    for name in variables:
        unit = coarse.table.units[name]
        if coarse.status != "completed" or fine.status != "completed":
            reached = float(coarse.times[-1]) if len(coarse.times) else 0.0
            found.append(CouplingError(name, unit, np.inf, reached))
            continue
        halved = fine[name][::2]
        difference = np.abs(coarse[name][: len(halved)] - halved)
        worst = int(np.argmax(difference))
        found.append(CouplingError(name, unit, factor * float(difference[worst]), float(coarse.times[worst])))
    return tuple(found)

"""Bound of the coupling error: a run is compared with one that has half its communication step."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from warmlink.fmus.records import dataclass
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.doubling import StepDoubling
from warmlink.orchestration.master.algorithms.iterated import InterfaceNewton
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.slaves.slave import SlaveError

SAFETY = 1.5
BOLD = (100.0, 10.0, 1.0)


@dataclass(frozen=True)
class Attempt:
    """A run by an algorithm, and its bounded coupling errors.

    Attributes
    ----------
    bounds : by variable, in its unit; none where there was no second run, infinite where that ended early
    broken : why the run at half the step ended early; None where it did not
    missed : variables whose bounds exceed their tolerances
    """

    algorithm: Algorithm
    result: Result
    bounds: Mapping[str, float]
    broken: str | None
    missed: Sequence[str]

    @property
    def stopped(self) -> str | None:
        """Why one of the two runs ended early."""
        return self.result.reason or self.broken


def attempted(
    algorithm: Algorithm,
    tolerances: Mapping[str, float],
    watched: Sequence[str] | None,
    once: Callable[[Algorithm, bool], Result],
    *,
    repeats: bool = True,
) -> Attempt:
    """Run until the bounds of the coupling errors are within the tolerances, or nothing is left to try.

    Parameters
    ----------
    algorithm : Algorithm
        Is tried first: its steps all have one size and cost least. Then follow steps that follow the error.
    tolerances : mapping
        By variable, in its unit; empty where a single attempt is to be made.
    watched : sequence of str, optional
        Variables whose errors are bounded; default: all that are recorded.
    once : callable
        Does a run by an algorithm, the second one at half the step.
    repeats : bool
        Whether there is a second run.

    Raises
    ------
    SlaveError
        Where the first attempt fails before its first value; a later one that fails costs no earlier one.
    """
    kept: Attempt | None = None
    for whole, finer in _ways(algorithm, tolerances):
        try:
            result = once(whole, False)
        except SlaveError:
            if kept is None:
                raise
            return kept
        bounds, broken = dict[str, float](), None
        if repeats and result.status == "completed":
            names = watched or result.table.names
            try:
                fine = once(finer, True)
                bounds, broken = coupling_error(result, fine, whole.order, names), fine.reason
            except KeyboardInterrupt:
                bounds, broken = dict.fromkeys(names, np.inf), "interrupted"
            except SlaveError as fault:  # before the second run's first value
                bounds, broken = dict.fromkeys(names, np.inf), str(fault)
        missed = [name for name, bound in bounds.items() if bound > tolerances.get(name, np.inf)]
        broken = broken and f"{broken} in the run at half the step"
        if kept is None or result.status == "completed" or kept.result.status != "completed":
            kept = Attempt(whole, result, bounds, broken, missed)
        if broken is not None or (not missed and result.error is None):
            break
    assert kept is not None
    return kept


def _ways(algorithm: Algorithm, tolerances: Mapping[str, float]) -> Iterator[tuple[Algorithm, Algorithm]]:
    """Give algorithms in the order in which they are tried, each with that of the run at half the step.

    Where the error sets the step, that is one with a tolerance that halves the steps. The first of these
    allow more than the tolerance, since most errors die out again, which step doubling does not count on.
    """
    yield algorithm, algorithm
    inner = InterfaceNewton(tolerance=1e-5)
    for bold in BOLD if tolerances else ():
        following, finer = (
            StepDoubling(inner, {name: share * bold * most for name, most in tolerances.items()})
            for share in (1.0, 0.5**inner.order)
        )
        yield following, finer


def coupling_error(coarse: Result, fine: Result, order: int, variables: Sequence[str]) -> dict[str, float]:
    """Bound the largest absolute coupling error of each variable over a run, in its unit (Richardson).

    Parameters
    ----------
    coarse, fine : Result
        Two runs of one system; `fine` has half the communication step size of `coarse`, and may end earlier:
        the bound then holds for that part, in which a warm-up has its largest coupling errors. Where one
        stopped early, the bounds are infinite.
    order : int
        The algorithm's order of convergence, p: where it is reached, the two differ by (1 - 2**-p) of the
        coarse run's error. Jumps in the inputs can lower it to 1; the factor 1.5 covers both.
    variables : sequence of str
        Recorded in both.
    """
    if not coarse.status == fine.status == "completed":
        return dict.fromkeys(variables, np.inf)
    factor, found = SAFETY / (1.0 - 0.5**order), {}
    for name in variables:
        halved = fine[name][::2]
        found[name] = factor * float(np.max(np.abs(coarse[name][: len(halved)] - halved)))
    return found

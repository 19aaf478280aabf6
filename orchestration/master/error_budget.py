"""Bound of the coupling error: a run is compared with one that has half its communication step."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.doubling import StepDoubling
from warmlink.orchestration.master.algorithms.iterated import InterfaceNewton
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.slaves.slave import SlaveError

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


def bounded(
    coarse: Result, again: Callable[[], Result], order: int, variables: Sequence[str]
) -> tuple[dict[str, float], str | None]:
    """Bound the coupling errors of a run by a second one, which costs the first one nothing if it fails.

    Parameters
    ----------
    coarse : Result
        The first run, completed.
    again : callable
        Does the run at half the step.
    order, variables : int, sequence of str
        As `coupling_error` takes them.

    Returns
    -------
    tuple
        The bounds, infinite where the second run ended early, and why it did; None where it did not.
    """
    try:
        fine = again()
        bounds, reason = coupling_error(coarse, fine, order, variables), fine.reason
    except KeyboardInterrupt:
        bounds, reason = dict.fromkeys(variables, np.inf), "interrupted"
    except SlaveError as fault:  # before the second run's first value
        bounds, reason = dict.fromkeys(variables, np.inf), str(fault)
    return bounds, reason and f"{reason} in the run at half the step"


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

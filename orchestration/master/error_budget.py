"""How wrong the coupling may be: a run against one with half its communication step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from warmlink.orchestration.master.recording.result import Result

SAFETY = 1.5


@dataclass(frozen=True)
class CouplingError:
    """Bound of the coupling error of one variable.

    Attributes
    ----------
    variable : str
        As `link.elongation`.
    unit : str or None
        The variable's.
    largest : float
        Bound of the largest absolute error over the run, in `unit`; infinite where a run did not get to
        the end.
    time : float
        When the two runs differ most, in s.
    """

    variable: str
    unit: str | None
    largest: float
    time: float


def coupling_error(
    coarse: Result, fine: Result, order: int, variables: Sequence[str]
) -> tuple[CouplingError, ...]:
    """Bound the coupling error of a run by one with half its step (Richardson).

    The difference of the two is (1 - 2**-p) of the coarse run's error where the order p is reached. Jumps
    in the inputs can lower that to 1: the factor 1.5 covers both.

    Parameters
    ----------
    coarse, fine : Result
        Of the same system; `fine` with half the communication step size of `coarse`.
    order : int
        The algorithm's order of convergence.
    variables : sequence of str
        Recorded in both.
    """
    factor = SAFETY / (1.0 - 0.5**order)
    found = []
    for name in variables:
        unit = coarse.table.units[name]
        if coarse.status != "completed" or fine.status != "completed":
            found.append(
                CouplingError(name, unit, np.inf, float(coarse.times[-1]) if len(coarse.times) else 0.0)
            )
            continue
        difference = np.abs(coarse[name] - fine[name][::2])
        worst = int(np.argmax(difference))
        found.append(CouplingError(name, unit, factor * float(difference[worst]), float(coarse.times[worst])))
    return tuple(found)


def estimate_coupling_error(
    run: Callable[[float, float], Result],
    coarse: Result,
    step_size: float,
    order: int,
    variables: Sequence[str],
    *,
    share: float = 1.0,
) -> tuple[CouplingError, ...]:
    """Repeat a run with half the step, wholly or in part, and bound the coupling error.

    Parameters
    ----------
    run : callable
        `(stop_time, step_size) -> Result`, both in s; records `variables`.
    coarse : Result
        The run with `step_size`.
    step_size : float
        In s.
    order : int
        The algorithm's order of convergence.
    variables : sequence of str
        To be bounded.
    share : float
        Opening share of the run that is repeated; the bound then holds for that part alone, which for a
        warm-up from cold is where coupling errors are largest.
    """
    steps = len(coarse.times) - 1
    kept = min(steps, max(1, round(share * steps)))
    stop = float(coarse.times[kept])
    table = coarse.table.head(kept + 1)
    part = Result(table, coarse.status, coarse.reason)
    return coupling_error(part, run(stop, step_size / 2), order, variables)

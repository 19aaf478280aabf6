"""A plain calibration judged on all of a log, one part after another, each by a fit that did not see it.

The end of a log is one part alone. Where it is unlike the rest, it says how well the rest tells of it, and
not how well a fit to the whole log tells of another one. M. Stone, Journal of the Royal Statistical Society B
36 (1974) 111-147.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.fitted import Carried
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.ladder.judged import CALIBRATED, UNCORRECTED, ladder_on
from warmlink.orchestration.diagnosis.ladder.plain import plainly_calibrated
from warmlink.orchestration.diagnosis.ladder.remainder import leaves_out_runs
from warmlink.orchestration.diagnosis.ladder.rungs import Ladder, Rung
from warmlink.orchestration.diagnosis.ladder.signals import signals_of

PARTS = 4
"""Parts of a log that are left out one after another."""


def judged_by_parts(problem: Problem, stands: Fit) -> Ladder:
    """The model as it stands and its plain calibration on every row, each by the other parts of the log.

    Each fit begins at the usual values: one that began at a fit to all rows would still know of them.

    Parameters
    ----------
    problem : with all the rows that are judged, each of them fitted
    stands : the model as it stands, of a system with usual parameters
    """
    as_fitted = [data.fitted for data in problem.data]
    foretold = [np.full(data.readings.shape, np.nan) for data in problem.data]
    for part in _parts(problem):
        others = [fitted & ~here for fitted, here in zip(as_fitted, part, strict=True)]
        fit = plainly_calibrated(problem, rows=others)
        assert fit is not None  # as the system has usual parameters
        for table, said, here in zip(foretold, _readings(problem, fit), part, strict=True):
            table[here] = said[here]
    runs = tuple(replace(run, fitted=np.zeros_like(run.fitted)) for run in signals_of(problem))
    by_name = {UNCORRECTED: _readings(problem, stands), CALIBRATED: tuple(foretold)}
    rungs = [Rung(name, "simulation", readings, is_model=True) for name, readings in by_name.items()]
    return ladder_on(problem, runs, rungs)


def _readings(problem: Problem, fit: Fit) -> tuple[Array, ...]:
    """Readings of every run by a model."""
    return tuple(problem.finest(run, z) for run, z in enumerate(Carried(problem, fit).values))


def _parts(problem: Problem) -> Iterator[list[NDArray[np.bool_]]]:
    """Rows by run of each part: some of the runs if there are several, else some of the time of each."""
    times = [data.time for data in problem.data]
    if leaves_out_runs(problem):
        numbers = [np.full(time.size, run % PARTS) for run, time in enumerate(times)]
    else:
        numbers = [_by_time(time) for time in times]
    for part in range(PARTS):
        here = [number == part for number in numbers]
        if any(rows.any() for rows in here):
            yield here


def _by_time(time: Array) -> NDArray[np.int64]:
    """Number of the part that each row of a run is in."""
    share = (time - time[0]) / max(float(time[-1] - time[0]), 1e-9)
    return np.minimum((PARTS * share).astype(np.int64), PARTS - 1)

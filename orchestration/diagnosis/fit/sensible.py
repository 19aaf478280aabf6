"""Measurements that would only be misread are refused before any search."""

from __future__ import annotations

from functools import cache

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.measured import FEWEST_ROWS, Run, names_of
from warmlink.orchestration.diagnosis.data.thinning import SHORTEST
from warmlink.orchestration.diagnosis.fit.noise import FEWEST
from warmlink.orchestration.diagnosis.fit.problem import Problem

_MOVES = {"K": 1.0, "m": 2e-6}
"""Change in the simulation, by SI unit, from which a reading that never changes counts as dead."""

_JUMPS = {"K": 1.0, "m": 5e-6}
"""Standard deviation of a reading, by SI unit, that no instrument's noise alone would have."""

_UNORDERED, _ORDERED = 0.5, 0.25
"""Least disorder of rows in random order, and largest disorder of a smooth course."""


def refuse_senseless(experiment: Experiment) -> None:
    """Refuse runs with too little to fit, channels that never change while they should, and shuffled rows.

    Raises
    ------
    InputError
        Naming run and column.
    """
    for run in experiment.runs:
        rows = sum(int(np.isfinite(v[run.fitted]).sum()) for v in run.readings.values())
        if not run.heldout and rows < FEWEST_ROWS:
            raise InputError(
                f"{run.name}: only {rows} readings can be fitted; at least {FEWEST_ROWS} are needed"
            )
    names, unit = names_of(experiment.columns), experiment.rig.unit
    problem = cache(lambda: Problem(experiment))

    def simulated(run: Run, variable: str) -> Array:
        """What a run would read as the system stands, shape (rows,)."""
        index = experiment.runs.index(run)
        readings, _ = problem().predict(index, problem().neutral[index], ())
        return readings[:, problem().variables.index(variable)]

    read = [(run, v, each[np.isfinite(each)]) for run in experiment.runs for v, each in run.readings.items()]
    dead = [(run, v) for run, v, each in read if each.size >= FEWEST_ROWS and np.ptp(each) == 0.0]
    for run, v in dead:
        span = float(np.ptp(simulated(run, v)))
        if span > _MOVES.get(unit(v), np.inf):
            raise InputError(
                f"{run.name}: column {names[v]!r} never changes, while it should by about {span:.3g} "
                f"{unit(v)}; leave the column out"
            )
    for run in experiment.runs:
        moves = {v: np.nanstd(each) / _JUMPS.get(unit(v), np.inf) for v, each in run.readings.items()}
        moving = [v for v, size in moves.items() if size > 1]
        disordered = moving and all(_disorder(run.readings[v]) > _UNORDERED for v in moving)
        if disordered and all(_disorder(simulated(run, v)) < _ORDERED for v in moving):
            worst = max(moving, key=lambda v: moves[v])
            jump = float(np.sqrt(np.nanmean(np.diff(run.readings[worst]) ** 2)))
            raise InputError(
                f"{run.name}: every reading that moves jumps from row to row ({names[worst]} by {jump:.3g} "
                f"{unit(worst)}), where it should move slowly; put the rows in order of time, or look for a "
                "loose contact"
            )


def refuse_too_short(problem: Problem) -> None:
    """Refuse runs to fit in which averaging leaves too few readings to tell noise from anything else.

    Raises
    ------
    InputError
        Naming run and number.
    """
    for run, data in zip(problem.experiment.runs, problem.data, strict=True):
        kept = int(np.isfinite(data.readings[data.fitted]).sum(axis=0).max())
        if not run.heldout and kept < FEWEST:
            raise InputError(
                f"{run.name}: no column keeps more than {kept} readings to fit, means over {SHORTEST:g} s or "
                f"more; at least {FEWEST} are needed, so give a longer run"
            )


def _disorder(values: Array) -> float:
    """Von Neumann's ratio, halved: 0 where values follow each other smoothly, about 1 where at random.

    J. von Neumann, "Distribution of the ratio of the mean square successive difference to the variance",
    Annals of Mathematical Statistics 12 (1941) 367-395.
    """
    filled = values[np.isfinite(values)]
    return float(np.mean(np.diff(filled) ** 2) / (2 * np.var(filled))) if np.ptp(filled) else 0.0

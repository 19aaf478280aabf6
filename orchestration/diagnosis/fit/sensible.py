"""Measurements that would only be misread are refused before any search."""

from __future__ import annotations

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.clock import FEWEST_ROWS
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.data.thinning import SHORTEST
from warmlink.orchestration.diagnosis.fit.noise import FEWEST
from warmlink.orchestration.diagnosis.fit.problem import Problem

_MOVES = {"K": 1.0, "m": 2e-6}
"""Change in the simulation, by SI unit, from which a reading that never changes counts as dead."""


def refuse_senseless(experiment: Experiment) -> None:
    """Refuse runs with too little to fit, and channels that never change while they should.

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
    dead = [(run, v) for run in experiment.runs for v, values in run.readings.items() if _constant(values)]
    if dead:
        _refuse_dead(experiment, dead)


def refuse_too_short(problem: Problem) -> None:
    """Refuse runs to fit in which averaging leaves too few readings to tell noise from anything else.

    Raises
    ------
    InputError
        Naming run and number.
    """
    for run, data in zip(problem.experiment.runs, problem.data, strict=True):
        if run.heldout:
            continue
        kept = int(np.isfinite(data.readings[data.fitted]).sum(axis=0).max())
        if kept < FEWEST:
            raise InputError(
                f"{run.name}: no column keeps more than {kept} readings to fit, means over {SHORTEST:g} s or "
                f"more; at least {FEWEST} are needed, so give a longer run"
            )


def _constant(values: np.ndarray) -> bool:
    filled = values[np.isfinite(values)]
    return filled.size >= FEWEST_ROWS and float(np.ptp(filled)) == 0.0


def _refuse_dead(experiment: Experiment, dead: list[tuple[Run, str]]) -> None:
    problem = Problem(experiment)
    for run, variable in dead:
        index = experiment.runs.index(run)
        simulated, _ = problem.predict(index, problem.neutral[index])
        span = float(np.ptp(simulated[:, problem.variables.index(variable)]))
        unit = experiment.rig.unit(variable)
        if span > _MOVES.get(unit, np.inf):
            raise InputError(
                f"{run.name}: column {problem.names[variable]!r} never changes, while it should by about "
                f"{span:.3g} {unit}; leave the column out"
            )

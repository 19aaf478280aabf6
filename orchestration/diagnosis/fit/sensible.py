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
    dead = [(run, v) for run in experiment.runs for v, values in run.readings.items() if _constant(values)]
    if dead:
        _refuse_dead(experiment, dead)
    for run in experiment.runs:
        moving = [
            v
            for v, values in run.readings.items()
            if np.nanstd(values) > _JUMPS.get(experiment.rig.unit(v), np.inf)
        ]
        if moving and all(_disorder(run.readings[v]) > _UNORDERED for v in moving):
            _refuse_shuffled(experiment, run, moving)


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


def _disorder(values: np.ndarray) -> float:
    """Von Neumann's ratio, halved: 0 where values follow each other smoothly, about 1 where at random.

    J. von Neumann, "Distribution of the ratio of the mean square successive difference to the variance",
    Annals of Mathematical Statistics 12 (1941) 367-395.
    """
    filled = values[np.isfinite(values)]
    return float(np.mean(np.diff(filled) ** 2) / (2 * np.var(filled))) if np.ptp(filled) else 0.0


def _simulated(problem: Problem, run: Run, variable: str) -> np.ndarray:
    """What a run would read as the system stands, shape (rows,)."""
    index = problem.experiment.runs.index(run)
    return problem.predict(index, problem.neutral[index])[0][:, problem.variables.index(variable)]


def _refuse_shuffled(experiment: Experiment, run: Run, moving: list[str]) -> None:
    problem = Problem(experiment)
    if all(_disorder(_simulated(problem, run, v)) < _ORDERED for v in moving):
        worst = max(moving, key=lambda v: np.nanstd(run.readings[v]) / _JUMPS[experiment.rig.unit(v)])
        jump = float(np.sqrt(np.nanmean(np.diff(run.readings[worst]) ** 2)))
        raise InputError(
            f"{run.name}: every reading that moves jumps from row to row ({problem.names[worst]} by "
            f"{jump:.3g} {experiment.rig.unit(worst)}), where it should move slowly; put the rows in order "
            "of time, or look for a loose contact"
        )


def _refuse_dead(experiment: Experiment, dead: list[tuple[Run, str]]) -> None:
    problem = Problem(experiment)
    for run, variable in dead:
        span = float(np.ptp(_simulated(problem, run, variable)))
        unit = experiment.rig.unit(variable)
        if span > _MOVES.get(unit, np.inf):
            raise InputError(
                f"{run.name}: column {problem.names[variable]!r} never changes, while it should by about "
                f"{span:.3g} {unit}; leave the column out"
            )

"""What a model says of duty cycles that were not measured, and how far that may be trusted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.answer.duties import run_of
from warmlink.orchestration.diagnosis.answer.gain import Scores
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.rig import ELONGATION
from warmlink.orchestration.diagnosis.fit.algebra import root_of
from warmlink.orchestration.diagnosis.fit.fitting import Fit, by_number
from warmlink.orchestration.diagnosis.fit.neighbours import Neighbours
from warmlink.orchestration.diagnosis.fit.problem import Freed, Problem
from warmlink.orchestration.diagnosis.fit.residuals import Wrong
from warmlink.orchestration.diagnosis.fit.verdict import Assessment
from warmlink.orchestration.diagnosis.fit.wandering import Responses, Wander
from warmlink.orchestration.scenarios.duties import duty_files
from warmlink.orchestration.scenarios.scenario import DEFAULT_TOLERANCE

DUTIES = ("continuous", "heavy_payload", "light_payload", "emergency_stop", "shift_with_breaks")
"""Shipped duty cycles that are foreseen: fast, heavy, light, held at rest, and with pauses."""

_SPACING = 60.0
"""s between the points at which a duty cycle is foreseen."""

_SIGMAS = 1.96
"""Standard deviations on either side of a 95 % band."""


@dataclass(frozen=True)
class Claim:
    """Elongation that is foreseen for a duty cycle.

    Attributes
    ----------
    duty : name of the duty cycle
    time : s, shape (times,)
    elongation, before : by the model to use and by the uncorrected one, in m, shape (times,)
    band : half width of the 95 % band about the former, in m, shape (times,)
    """

    duty: str
    time: Array
    elongation: Array
    before: Array
    band: Array

    @property
    def largest(self) -> float:
        """Largest elongation in m."""
        return float(np.abs(self.elongation).max())

    @property
    def change(self) -> float:
        """Largest difference from the uncorrected model in m."""
        return float(np.abs(self.elongation - self.before).max())

    @property
    def widest(self) -> float:
        """Largest half width of the band in m."""
        return float(self.band.max())

    @property
    def holds(self) -> bool:
        """Whether the band is within the tolerance that compensation is asked to meet."""
        return self.widest <= DEFAULT_TOLERANCE


def claims(
    experiment: Experiment, assessment: Assessment, models: Sequence[Fit], left: Wrong | None
) -> tuple[Claim, ...]:
    """Foresee the standard duty cycles; of a warm-up cell whose elongation was read.

    The band adds up what is uncertain in the numbers, what wanders, the one further cause below the noise
    that would matter most, how far models that explain the data alike are apart, and the share of the
    elongation that the model left unexplained in the run.

    Parameters
    ----------
    experiment : what was measured
    assessment : what the search found
    models : the model to use from now on, and those that cannot be told from it
    left : errors of that model's elongation
    """
    if not experiment.rig.is_cell or left is None:
        return ()
    variables = tuple(dict.fromkeys(column.variable for column in experiment.columns))
    segments = [duty_files.load(name).unrolled() for name in DUTIES]
    first = next(run for run in experiment.runs if not run.heldout)
    runs = [
        replace(run_of(each, variables, 1.0, _SPACING), name=name, labels=first.labels)
        for name, each in zip(DUTIES, segments, strict=True)
    ]
    labelled = [run for run in experiment.runs if run.labels]  # causes by label need every value
    problem = Problem(replace(experiment, runs=(*labelled, *runs), initial_measured=False))
    measured = np.concatenate(
        [run.readings[ELONGATION] for run in experiment.runs if ELONGATION in run.readings]
    )
    share = float(np.sqrt(max(left.rmse**2 - left.noise**2, 0.0) / np.nanmean(measured**2)))
    chosen, *alike = (_Foreseen(problem, fit) for fit in models)
    before = _Foreseen(problem, assessment.null)
    further = Neighbours(models[0], assessment.search.items, ()).unnoticed()
    unnoticed = [off for item, off in further if item.cause.kind == "plant"]
    found = []
    for run, name in enumerate(DUTIES, start=len(labelled)):
        grown = chosen.elongation(run)
        variance = chosen.variance(run) + chosen.unnoticed(run, unnoticed) + (share * grown) ** 2
        variance += chosen.wandering(run, assessment.fitter.wander)
        band = _SIGMAS * np.sqrt(variance)
        for other in alike:
            band = np.maximum(band, np.abs(grown - other.elongation(run)))
        found.append(Claim(name, problem.data[run].time, grown, before.elongation(run), band))
    return tuple(found)


class _Foreseen:
    """The link's elongation by one model in every run of a problem, in m."""

    def __init__(self, problem: Problem, fit: Fit) -> None:
        self._problem, self._fit = problem, fit
        self._channel = problem.variables.index(ELONGATION)
        # What is wrong with logs and instruments is wrong in no other duty cycle.
        plant = {f.key for item in fit.items if item.cause.kind == "plant" for f in item.freed}
        freed, theta = Scores.carry(problem, fit)
        kept = [i for i, f in enumerate(freed) if f.calibrated or f.key in plant]
        self._freed, self._theta = [freed[i] for i in kept], theta[kept]
        self._there = {f.key: f for item in problem.items for f in item.freed} | {
            f.key: f for f in self._freed
        }
        runs = range(len(problem.data))
        self._values = [problem.values(run, self._freed, self._theta) for run in runs]
        self._predicted = [problem.predict(run, z) for run, z in zip(runs, self._values, strict=True)]

    def elongation(self, run: int) -> Array:
        return self._predicted[run][0][:, self._channel]

    def _by(self, run: int, freed: Sequence[Freed]) -> Array:
        """Derivatives of the elongation by numbers of another problem, shape (times, numbers)."""
        wanted = [self._there.get(f.key, replace(f, runs=())) for f in freed]
        return by_number(self._predicted[run][1][:, self._channel], wanted, run, self._freed)

    def variance(self, run: int) -> Array:
        """Of the fitted numbers."""
        columns = self._by(run, self._fit.freed) @ root_of(self._fit.covariance())
        return np.asarray(np.sum(columns**2, axis=-1))

    def unnoticed(self, run: int, further: Sequence[dict[Freed, float]]) -> Array:
        """Of the further cause that matters most here while the data say nothing about it."""
        worst = np.zeros(self._problem.data[run].time.size)
        for off in further:
            moved = self._by(run, list(off)) @ np.array(list(off.values()))
            worst = np.maximum(worst, moved**2)
        return worst

    def wandering(self, run: int, wander: Wander) -> Array:
        """Of what wanders beside its log."""
        if wander.still:
            return np.zeros(self._problem.data[run].time.size)
        columns = self._responses.columns[run][:, self._channel] @ self._responses.root(run, wander)
        return np.asarray(np.sum(columns**2, axis=-1))

    @cached_property
    def _responses(self) -> Responses:
        return Responses(self._problem, self._values)

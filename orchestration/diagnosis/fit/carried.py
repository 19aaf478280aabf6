"""A fitted model in a problem with other runs: what it predicts there, and how surely."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.algebra import root_of
from warmlink.orchestration.diagnosis.fit.fitting import Fit, by_number
from warmlink.orchestration.diagnosis.fit.problem import Freed, Problem
from warmlink.orchestration.diagnosis.fit.wandering import Responses, Wander


class Carried:
    """A fitted model carried over to a problem with other runs.

    A group that was never fitted takes the mean of those that were.

    Parameters
    ----------
    problem : with the same candidates
    fit : the model
    plant_only : leave out causes in logs and instruments, which are wrong in the fitted runs alone

    Attributes
    ----------
    freed : the model's numbers in the problem
    values : slots by run, shape (slots,) each
    """

    def __init__(self, problem: Problem, fit: Fit, plant_only: bool = False) -> None:
        self._problem, self._fit = problem, fit
        fitted = {f.key: v for f, v in fit.values.items()}
        items = [i for i in problem.items if i.title in fit.key]
        kept = [i for i in items if i.cause.kind == "plant" or not plant_only]
        self.freed = [*problem.calibrated, *(f for item in kept for f in item.freed)]
        theta = []
        for f in self.freed:
            like = [v for (name, _, free), v in fitted.items() if (name, free) == (f.variable, f.calibrated)]
            own = f.calibrated and f.added  # a start is that of its run alone
            theta.append(fitted.get(f.key, float(np.mean(like)) if like and not own else f.start))
        self.values = problem.values_by_run(self.freed, theta)
        every = [*problem.calibrated, *(f for item in problem.items for f in item.freed)]
        self._there = {f.key: f for f in every}
        self._predicted: dict[int, tuple[Array, Array]] = {}

    def predict(self, run: int) -> tuple[Array, Array]:
        """Readings of a run and their derivatives by slot, as the problem gives them."""
        if run not in self._predicted:
            self._predicted[run] = self._problem.predict(run, self.values[run])
        return self._predicted[run]

    def by(self, run: int, numbers: Sequence[Freed]) -> Array:
        """Derivatives of a run's readings by numbers of another problem, shape (rows, outputs, numbers)."""
        wanted = [self._there.get(f.key, replace(f, runs=())) for f in numbers]
        return by_number(self.predict(run)[1], wanted, run, self.freed)

    def variance(self, run: int) -> Array:
        """Of a run's readings, for how uncertain the fitted numbers are, shape (rows, outputs)."""
        columns = self.by(run, self._fit.freed) @ root_of(self._fit.covariance())
        return np.asarray(np.sum(columns**2, axis=-1))

    def wandering(self, run: int, wander: Wander) -> Array:
        """Variance of a run's readings for what wanders beside its log, shape (rows, outputs)."""
        if wander.still:
            return np.zeros(self.predict(run)[0].shape)
        columns = self._responses.columns[run] @ self._responses.root(run, wander)
        return np.asarray(np.sum(columns**2, axis=-1))

    @cached_property
    def _responses(self) -> Responses:
        return Responses(self._problem, self.values)

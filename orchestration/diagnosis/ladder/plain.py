"""A plain calibration of a machine's usual parameters, which asks for no cause.

Errors of a model that lacks something are no noise: each channel counts by what is left in it, and as many
rows as a slow course has independent ones. Numbers are held near their usual values by a prior. Spikes are
weighed down by the loss (P. J. Huber, Annals of Mathematical Statistics 35 (1964) 73-101, smoothed).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.candidates import FreeNumber, Item
from warmlink.orchestration.diagnosis.fit.fitting import Fit, Fitter, by_number
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.model.simulation import NotSimulatedError
from warmlink.orchestration.progress import Progress, unseen

_INDEPENDENT = 30.0
"""Independent errors that count in each channel of a run, however many rows it has."""

_APART, _MATERIAL, _ADDED = 0.5, 0.03, 0.2
"""By how much of itself a usual value is off, 1 sigma; a material's; and of its bounds what is usually 0."""

_ROUNDS, _MOST_EVALUATIONS = 2, 12
"""Times that the channels' weights are taken anew, and simulations in each."""


def usual_items(problem: Problem) -> tuple[Item, ...]:
    """Candidates that free a usual parameter of the machine in all runs alike."""
    return tuple(each for each in problem.items if each.cause.usual and not each.label)


def plainly_calibrated(fitter: Fitter, progress: Progress = unseen) -> Fit | None:
    """The usual parameters fitted together to the fitted rows; None if the system has none of them."""
    from scipy.optimize import least_squares

    problem, items = fitter.problem, usual_items(fitter.problem)
    freed = tuple(f for item in items for f in item.freed)
    if not freed:
        return None
    start, lower, upper = np.array([(f.start, f.lower, f.upper) for f in freed]).T
    spread = np.array([_off(item.cause.material, f) for item in items for f in item.freed])
    sought = _Residuals(problem, freed, start, spread)
    place = np.zeros(len(freed))
    low, high = (lower - start) / spread - 1e-9, (upper - start) / spread + 1e-9
    for k in range(_ROUNDS):
        sought.weigh(place)

        def residual(at: Array, k: int = k) -> Array:
            progress("plain calibration", k / _ROUNDS)
            return sought(at)[0]

        found: Any = least_squares(
            residual,
            place,
            lambda at: sought(at)[1],
            bounds=(low, high),
            loss="soft_l1",
            f_scale=3.0,
            ftol=1e-4,
            xtol=1e-4,
            max_nfev=_MOST_EVALUATIONS,
        )
        place = found.x
    theta = np.clip(start + spread * place, lower, upper)
    return Fit(items, freed, theta, fitter.at(freed, theta), (False,) * len(freed))


def _off(material: bool, number: FreeNumber) -> float:
    """By how much a number is usually off, 1 sigma in SI."""
    return (_MATERIAL if material else _APART) * abs(number.start) or _ADDED * number.span


class _Residuals:
    """Weighted errors on fitted rows and distances from the usual values, with derivatives by places."""

    def __init__(self, problem: Problem, freed: tuple[FreeNumber, ...], start: Array, spread: Array) -> None:
        self._problem, self._freed, self._start, self._spread = problem, freed, start, spread
        self._weights = [np.ones(len(problem.variables)) for _ in problem.data]
        self._at: tuple[bytes, Array, Array] | None = None

    def weigh(self, place: Array) -> None:
        """Take each channel's weight from what is left in it at some place, by run."""
        for run, (error, _) in enumerate(self._errors(place)):
            count = np.maximum(np.isfinite(error).sum(axis=0), 1)
            with np.errstate(invalid="ignore"):
                typical = 1.4826 * np.nan_to_num(
                    np.nanmedian(np.abs(np.where(count > 1, error, 0.0)), axis=0)
                )
            size = np.maximum(typical, self._problem.scatter_in(run))
            self._weights[run] = np.minimum(1.0, np.sqrt(_INDEPENDENT / count)) / size
        self._at = None

    def _errors(self, place: Array) -> list[tuple[Array, Array]]:
        """Errors by run, NaN where not fitted, shape (rows, channels), and derivatives by numbers."""
        theta, result = self._start + self._spread * place, []
        for run, data in enumerate(self._problem.data):
            values, by_slot = self._problem.predict(run, self._problem.values(run, self._freed, theta))
            error = np.where(data.fitted[:, None], data.readings - values, np.nan)
            result.append((error, by_number(by_slot, self._freed, run, self._freed)))
        return result

    def __call__(self, place: Array) -> tuple[Array, Array]:
        key = place.tobytes()
        if self._at is None or self._at[0] != key:
            try:
                every = self._errors(place)
            except NotSimulatedError:
                if self._at is None:
                    raise
                return 1e3 * np.abs(self._at[1]), self._at[2]
            residuals, slopes = [place], [np.eye(place.size)]
            for (error, by_place), weight in zip(every, self._weights, strict=True):
                good = np.isfinite(error)
                residuals.append((error * weight)[good])
                slopes.append(-(by_place * weight[:, None] * self._spread)[good])
            self._at = key, np.concatenate(residuals), np.concatenate(slopes)
        return self._at[1], self._at[2]

"""A plain calibration of a machine's usual parameters, which asks for no cause.

Errors of a model that lacks something are no noise: each channel counts by a share of how far it goes, and
as many rows as a slow course has independent ones. The share is the same in all runs, so that no run counts
less because the model is bad in it. Numbers are held near their usual values by a prior, sizes by their
logarithm: what a log does not tell apart, as copper loss and friction at one speed and torque, stays as it is
usually, or duty cycles that were never seen would be foretold worse than before. Spikes are weighed down by
the loss (P. J. Huber, Annals of Mathematical Statistics 35 (1964) 73-101, smoothed).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.candidates import FreeNumber, Item
from warmlink.orchestration.diagnosis.fit.fitting import Fit, FitPoint, by_number
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.model.simulation import NotSimulatedError
from warmlink.orchestration.progress import Progress, unseen

Rows = Sequence[NDArray[np.bool_]]
"""Which rows count, by run."""

_INDEPENDENT = 30.0
"""Independent errors that count in each channel of a run, however many rows it has."""

_MISSING, _ADDED = 0.02, 0.1
"""Shares of how far a channel goes: what a model that lacks something leaves, and what a number that is
usually 0 adds to the channel that it moves most, 1 sigma."""

_APART, _MATERIAL = 0.3, 0.03
"""By how much of itself a usual value is off, 1 sigma, and a material's."""

_LARGEST = 0.2
"""Share of its bounds by which a number that is usually 0 is off, at most."""

_FAR = 8.0
"""Standard deviations of the prior beyond which nothing is sought."""

_MOST_EVALUATIONS = 15
"""Simulations of all fitted rows."""


def usual_items(problem: Problem) -> tuple[Item, ...]:
    """Candidates that free a usual parameter of the machine in all runs alike."""
    usual = (each for each in problem.items if each.cause.usual or each.cause.unsought)
    return tuple(each for each in usual if not each.label)


def plainly_calibrated(problem: Problem, progress: Progress = unseen, rows: Rows | None = None) -> Fit | None:
    """The usual parameters fitted together to the fitted rows; None if the system has none of them.

    Chi-square and covariance of the fit go by the errors that such a model leaves and by the prior, so that
    what the log does not tell is known as well as it usually is.

    Parameters
    ----------
    problem : with the fitted rows
    progress : is told how it goes
    rows : rows to fit by run, if these are not all fitted ones
    """
    from scipy.optimize import least_squares

    items = usual_items(problem)
    freed = tuple(f for item in items for f in item.freed)
    if not freed:
        return None
    apart = [_MATERIAL if item.cause.material else _APART for item in items for _ in item.freed]
    sought = _Residuals(problem, freed, np.array(apart), rows)

    def residual(place: Array) -> Array:
        progress(f"plain calibration of {len(freed)} numbers", 0.0)
        return sought(place)[0]

    found: Any = least_squares(
        residual,
        np.zeros(len(freed)),
        lambda place: sought(place)[1],
        bounds=sought.bounds,
        loss="soft_l1",
        f_scale=3.0,
        ftol=1e-4,
        xtol=1e-4,
        max_nfev=_MOST_EVALUATIONS,
    )
    theta = sought.values(found.x)
    return Fit(items, freed, theta, sought.point(theta), (False,) * len(freed))


class _Residuals:
    """Weighted errors on fitted rows, and places: distances from the usual values in units of the prior.

    Parameters
    ----------
    problem : with the fitted rows
    freed : numbers
    spread : by how much of itself each is usually off, 1 sigma, shape (numbers,)
    rows : rows to fit by run; None for all fitted ones
    """

    def __init__(
        self, problem: Problem, freed: Sequence[FreeNumber], spread: Array, rows: Rows | None
    ) -> None:
        self._problem, self._freed = problem, tuple(freed)
        self._rows = [data.fitted for data in problem.data] if rows is None else list(rows)
        self._start, self._lower, self._upper = np.array([(f.start, f.lower, f.upper) for f in freed]).T
        self._is_size = self._start > 0
        goes = _how_far(problem, self._rows)
        self._scales = [
            np.hypot(problem.scatter_in(run), _MISSING * goes) for run in range(len(problem.data))
        ]
        self._counts = [
            np.maximum(np.isfinite(data.readings[fitted]).sum(axis=0), 1)
            for data, fitted in zip(problem.data, self._rows, strict=True)
        ]
        self._spread = np.where(self._is_size, spread, self._added(goes))
        self._at: tuple[bytes, Array, Array] | None = None

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Places of the bounds, as far as anything is sought, shape (numbers,) each."""
        least = np.where(self._is_size, self._start * np.exp(-_FAR), 0.0)
        low = self._place(np.maximum(self._lower, np.where(self._is_size, least, self._lower)))
        high = self._place(self._upper)
        return np.maximum(low, -_FAR) - 1e-9, np.minimum(high, _FAR) + 1e-9

    def _place(self, theta: Array) -> Array:
        ratio = np.where(self._is_size, theta / np.where(self._is_size, self._start, 1.0), 1.0)
        return np.where(self._is_size, np.log(ratio), theta - self._start) / self._spread

    def values(self, place: Array) -> Array:
        """Numbers in SI at a place."""
        grown = np.exp(np.where(self._is_size, self._spread * place, 0.0))
        theta = np.where(self._is_size, self._start * grown, self._start + self._spread * place)
        return np.clip(theta, self._lower, self._upper)

    def _added(self, goes: Array) -> Array:
        """By how much a number that is usually 0 is off, 1 sigma: so that it adds a share to some channel."""
        adds = np.zeros(len(self._freed))
        for run, (_, by) in enumerate(self._errors(self._start)):
            here = by[self._rows[run]]
            if here.size:
                adds = np.maximum(adds, (np.sqrt(np.mean(here**2, axis=0)) / goes[:, None]).max(axis=0))
        span = _LARGEST * (self._upper - self._lower)
        return np.minimum(_ADDED / np.maximum(adds, _ADDED / span), span)

    def _errors(self, theta: Array) -> list[tuple[Array, Array]]:
        """Errors by run, NaN where not fitted, shape (rows, channels), and derivatives by numbers."""
        return [
            (error, by_number(by_slot, self._freed, run, self._freed))
            for run, (error, by_slot) in enumerate(self._by_slot(theta, self._freed))
        ]

    def _by_slot(self, theta: Array, by: Sequence[FreeNumber] | None) -> list[tuple[Array, Array]]:
        """The same with the derivatives by slot, as `Problem.predict` has them."""
        result = []
        for run, data in enumerate(self._problem.data):
            values, by_slot = self._problem.predict(run, self._problem.values(run, self._freed, theta), by)
            result.append((np.where(self._rows[run][:, None], data.readings - values, np.nan), by_slot))
        return result

    @cached_property
    def _weights(self) -> list[Array]:
        """Weight of each error by run, shape (channels,) or (rows, channels)."""
        pairs = zip(self._scales, self._counts, strict=True)
        return [np.minimum(1.0, np.sqrt(_INDEPENDENT / count)) / scale for scale, count in pairs]

    def _rise(self, theta: Array) -> Array:
        """By how much each number in SI changes with its place."""
        return self._spread * np.where(self._is_size, theta, 1.0)

    def point(self, theta: Array) -> FitPoint:
        """Chi-square and its linearisation at numbers in SI, the prior added to a slot of each number."""
        grams = []
        for (error, by_slot), weight in zip(self._by_slot(theta, None), self._weights, strict=True):
            joined = np.concatenate([error[:, :, None], by_slot], axis=2) * weight[..., None]
            joined = joined[np.isfinite(error)]
            grams.append(joined.T @ joined)
        for freed, rise, place in zip(self._freed, self._rise(theta), self._place(theta), strict=True):
            slot, gram = 1 + freed.slots[0], grams[freed.runs[0]]
            gram[0, 0] += place**2
            gram[slot, slot] += 1 / rise**2
            gram[[0, slot], [slot, 0]] -= place / rise
        return FitPoint.of(grams)

    def __call__(self, place: Array) -> tuple[Array, Array]:
        """Residuals, the places among them, and their derivatives by places."""
        key = place.tobytes()
        if self._at is None or self._at[0] != key:
            theta = self.values(place)
            try:
                every = self._errors(theta)
            except NotSimulatedError:
                if self._at is None:
                    raise
                return 1e3 * np.abs(self._at[1]), self._at[2]
            rise = self._rise(theta)
            residuals, slopes = [place], [np.eye(place.size)]
            for (error, by), weight in zip(every, self._weights, strict=True):
                good = np.isfinite(error)
                residuals.append((error * weight)[good])
                slopes.append(-(by * weight[..., None] * rise)[good])
            self._at = key, np.concatenate(residuals), np.concatenate(slopes)
        return self._at[1], self._at[2]


def _how_far(problem: Problem, rows: Rows) -> Array:
    """How far each channel goes on the fitted rows of all runs, or its scatter, in SI, shape (channels,)."""
    least = np.max([problem.scatter_in(run) for run in range(len(problem.data))], axis=0)
    table = np.concatenate([data.readings[here] for data, here in zip(problem.data, rows, strict=True)])
    read = [column[np.isfinite(column)] for column in table.T]
    return np.maximum([np.ptp(column) if column.size else 0.0 for column in read], least)

"""Calibration that arrives: from several starting points, by a trust region, strengths by their logarithm.

A Gauss-Newton step from far away may lie beyond every bound, and halving it wastes a simulation each time.
M. A. Branch, T. F. Coleman and Y. Li, SIAM Journal on Scientific Computing 21 (1999) 1-23, as SciPy has it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import count

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.candidates import FreeNumber
from warmlink.orchestration.diagnosis.fit.fitted import Wrong, what_is_wrong
from warmlink.orchestration.diagnosis.fit.fitting import Fit, Fitter, by_number
from warmlink.orchestration.diagnosis.fit.noise import NoiseModel
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.model.simulation import NotSimulatedError
from warmlink.orchestration.progress import Progress, stretch, unseen

_MOST_EVALUATIONS = 60
"""Simulations from one starting point."""

_WIDE = 4.0
"""Ratio of the bounds from which a strength is sought by its logarithm."""

_SAME = 0.01
"""Share of chi-square by which two starting points may end apart for there to be one minimum."""

_ARRIVED, _MOST_REFINED = 1.0, 3
"""Standard deviations that a fit may move once the grid's error is taken out anew, and how often it is."""

_FURTHER = ((0.25, 0.75), (0.75, 0.25))
"""Places between the bounds, alternately by number, of starts that are tried where others disagree."""


class _TimeIsUpError(Exception):
    """The time limit has passed."""


_FAILED = 1e3
"""Times the first residuals that count where nothing can be simulated."""


@dataclass(frozen=True)
class AsItStands:
    """The uncorrected model, calibrated; the same whether causes are looked for or not.

    Attributes
    ----------
    fit : the model
    noise : by channel, as estimated before any cause was tried
    wrong : errors on the fitted rows by column name
    """

    fit: Fit
    noise: tuple[NoiseModel, ...]
    wrong: Mapping[str, Wrong]


def calibrated(fitter: Fitter, progress: Progress = unseen) -> Fit:
    """The best calibration of the model as it stands, from the given start and from the middle of the bounds.

    Where these end at different values, further starts are tried.
    """
    freed = fitter.problem.calibrated
    if all(each.added for each in freed):
        return fitter.fit(())
    sought = _Sought(fitter, freed)
    given = np.array([each.start for each in freed])
    starts = [given, sought.between(np.full(given.size, 0.5))]
    ends: list[tuple[float, Array]] = []
    while len(ends) < len(starts) and not (ends and fitter.problem.out_of_time()):
        k, most = len(ends), len(starts)
        doing = f"calibrating from start {k + 1} of {most}"
        ends.append(sought.minimum(starts[k], stretch(progress, k / most, (k + 1) / most), doing))
        if len(ends) == 2 and abs(ends[0][0] - ends[1][0]) > _SAME * min(ends[0][0], ends[1][0]):
            starts += [sought.between(np.resize(places, given.size)) for places in _FURTHER]
    _, best = min(ends, key=lambda end: end[0])
    return fitter.fit((), dict(zip(freed, best.tolist(), strict=True)))


def as_it_stands(fitter: Fitter, fit: Fit) -> AsItStands:
    """The uncorrected model where its fit arrives."""
    fit = refined(fitter, fit)
    return AsItStands(fit, fitter.noise, what_is_wrong(fitter, fit))


def refine(problem: Problem, fit: Fit) -> None:
    """Take the grid's error out as it is with a fit's values."""
    problem.refine(problem.values_by_run(fit.freed, fit.theta))


def refined(fitter: Fitter, fit: Fit) -> Fit:
    """A fit again, until the grid's error and what is linear are those where it ends."""
    for _ in range(_MOST_REFINED):
        refine(fitter.problem, fit)
        before, fit = fit, fitter.fit(fit.items, fit.values)
        if not moved(before, fit):
            break
    return fit


def moved(before: Fit, after: Fit) -> bool:
    """Whether a fit moved by more than is known of its numbers."""
    apart = np.abs(after.theta - before.theta)
    return bool(np.any(apart > _ARRIVED * np.sqrt(np.diag(after.covariance()))))


class _Sought:
    """Numbers as they are sought: each between 0 and 1, evenly or by the logarithm."""

    def __init__(self, fitter: Fitter, freed: Sequence[FreeNumber]) -> None:
        self._fitter, self._freed = fitter, tuple(freed)
        self._lower = np.array([each.lower for each in freed])
        self._upper = np.array([each.upper for each in freed])
        wide = (self._lower > 0) & (self._upper > _WIDE * self._lower)
        self._rise = np.where(wide, np.log(self._upper / np.where(wide, self._lower, 1.0)), 0.0)
        self._at: tuple[bytes, Array, Array] | None = None

    def between(self, places: Array) -> Array:
        """Values at places from 0 to 1."""
        evenly = self._lower + places * (self._upper - self._lower)
        return np.where(self._rise > 0, self._lower * np.exp(self._rise * places), evenly)

    def _places(self, theta: Array) -> Array:
        evenly = (theta - self._lower) / (self._upper - self._lower)
        rise = np.where(self._rise > 0, self._rise, 1.0)
        return np.where(self._rise > 0, np.log(np.maximum(theta, 1e-300) / self._lower_or_1) / rise, evenly)

    @property
    def _lower_or_1(self) -> Array:
        return np.where(self._rise > 0, self._lower, 1.0)

    def minimum(self, start: Array, progress: Progress, doing: str) -> tuple[float, Array]:
        """Chi-square and values where the search from a start ends."""
        from scipy.optimize import least_squares

        tried = count(1)
        best: tuple[float, tuple[float, ...]] = (np.inf, ())

        def residual(places: Array) -> Array:
            step = next(tried)
            told = f"{doing}, step {step} of at most {_MOST_EVALUATIONS}"
            progress(told, min(1.0, step / _MOST_EVALUATIONS))
            if step > 1 and self._fitter.problem.out_of_time():
                raise _TimeIsUpError
            residuals = self._residual(places)[0]
            nonlocal best
            best = min(best, (float(residuals @ residuals), tuple(places.tolist())))
            return residuals

        begin = np.clip(self._places(start), 1e-6, 1 - 1e-6)
        with suppress(_TimeIsUpError):
            least_squares(
                residual,
                begin,
                lambda places: self._residual(places)[1],
                bounds=(0.0, 1.0),
                x_scale="jac",
                ftol=1e-6,
                xtol=1e-7,
                max_nfev=_MOST_EVALUATIONS,
            )
        return best[0], self.between(np.array(best[1]))

    def _residual(self, places: Array) -> tuple[Array, Array]:
        """Whitened residuals and their derivatives by places."""
        key = places.tobytes()
        if self._at is None or self._at[0] != key:
            theta = self.between(places)
            try:
                every = self._fitter.whitened(self._freed, theta)
            except NotSimulatedError:
                if self._at is None:
                    raise
                return _FAILED * np.abs(self._at[1]), self._at[2]
            slope = np.where(self._rise > 0, self._rise * theta, self._upper - self._lower)
            by = [by_number(each[:, 1:], self._freed, run, self._freed) for run, each in enumerate(every)]
            residual = np.concatenate([each[:, 0] for each in every])
            self._at = key, residual, -np.concatenate(by) * slope
        return self._at[1:]

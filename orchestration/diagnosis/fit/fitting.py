"""Bounded Gauss-Newton fits, and what they predict for similar models.

A fit ends with the Gram matrices of the whitened sensitivities to *every* slot. From these alone the
outcome of freeing other variables, or of taking some back, is predicted without another simulation.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.algebra import bounded_step, inverse_of
from warmlink.orchestration.diagnosis.fit.candidates import FreeNumber, Item
from warmlink.orchestration.diagnosis.fit.noise import NoiseModel, Whitener
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.wandering import STILL, Responses, Smoothing, Wander
from warmlink.orchestration.diagnosis.model.simulation import NotSimulatedError

_MOST_EVALUATIONS, _TRIED = 12, 3
"""Simulations that a fit may take, and those after which it may be given up."""

_BEYOND = 10.8
"""Chi-square that a bound must cost, by chance in one of a thousand, before it rejects what lies on it."""

_SMALL, _SHARE = 0.2, 1e-3
"""Decrease of chi-square below which a fit has converged: absolute, or as a share of chi-square."""

_SETTLED = 5.0
"""Decrease of chi-square from which on a step that does as it promised is the last one."""


Numbers = Sequence[FreeNumber]


@dataclass(frozen=True)
class FitPoint:
    """Sum of squared whitened residuals at some values of the freed variables, and its linearisation.

    `gram` and `gradient` are J'J and J'r by run, shapes (slots, slots) and (slots,).
    """

    chi2: float
    gram: tuple[Array, ...]
    gradient: tuple[Array, ...]

    @classmethod
    def of(cls, grams: Sequence[Array]) -> FitPoint:
        """The point of whitened residuals beside their derivatives, from the Gram matrix of each run."""
        chi2 = sum(float(gram[0, 0]) for gram in grams)
        return cls(chi2, tuple(gram[1:, 1:] for gram in grams), tuple(gram[1:, 0] for gram in grams))

    def moved(self, numbers: Numbers, change: Array, overriding: Numbers) -> FitPoint:
        """The same by the linearisation, after some of the `overriding` numbers have changed."""
        chi2, gradient = self.chi2, []
        for run, (gram, slope) in enumerate(zip(self.gram, self.gradient, strict=True)):
            step = slots_of(numbers, slope.size, run, overriding) @ change
            chi2 += float((gram @ step - 2 * slope) @ step)
            gradient.append(slope - gram @ step)
        return FitPoint(chi2, self.gram, tuple(gradient))


@dataclass(frozen=True)
class Fit:
    """A fitted model: its causes, its numbers `freed`, their values `theta` in SI, and chi-square there.

    `at_bound` says whether each number would rather lie beyond a physical bound, and `arrived` whether no
    further step, by the gradient there, would gain anything worth it.
    """

    items: tuple[Item, ...]
    freed: tuple[FreeNumber, ...]
    theta: Array
    point: FitPoint
    at_bound: tuple[bool, ...]
    arrived: bool = True

    @property
    def chi2(self) -> float:
        """Sum of squared whitened residuals."""
        return self.point.chi2

    @property
    def values(self) -> dict[FreeNumber, float]:
        """Value in SI of each number."""
        return dict(zip(self.freed, self.theta.tolist(), strict=True))

    @property
    def key(self) -> frozenset[str]:
        """Titles of the causes."""
        return frozenset(item.title for item in self.items)

    @property
    def name(self) -> str:
        """Titles of the causes, joined by plus."""
        return "+".join(sorted(self.key))

    @property
    def admissible(self) -> bool:
        """Whether no cause was driven to a bound."""
        pairs = zip(self.at_bound, self.freed, strict=True)
        return not any(bound for bound, freed in pairs if not freed.calibrated)

    @property
    def resting(self) -> bool:
        """Whether a cause lies on a physical bound, the neutral value excepted."""
        return any(f.on_bound(value) for f, value in self.values.items() if not f.calibrated)

    def covariance(self) -> Array:
        """Covariance of the fitted numbers in SI, shape (numbers, numbers)."""
        return inverse_of(of_numbers(self.freed, self.freed, self.point)[0], 1e-12)


def of_numbers(wanted: Numbers, overriding: Numbers, point: FitPoint) -> tuple[Array, Array]:
    """Gram matrix and gradient of chosen numbers, put together from those of the slots."""
    gram, gradient = np.zeros((len(wanted), len(wanted))), np.zeros(len(wanted))
    for run, (by_slot, slope) in enumerate(zip(point.gram, point.gradient, strict=True)):
        selection = slots_of(wanted, slope.size, run, overriding)
        gram += selection.T @ by_slot @ selection
        gradient += selection.T @ slope
    return gram, gradient


def by_number(by_slot: Array, wanted: Numbers, run: int, overriding: Numbers) -> Array:
    """Derivatives in a run by numbers, shape (..., numbers), from those by slot, shape (..., slots)."""
    return np.asarray(by_slot @ slots_of(wanted, by_slot.shape[-1], run, overriding))


def slots_of(wanted: Numbers, count: int, run: int, overriding: Numbers) -> Array:
    """Which of so many slots take each of some numbers in a run, 1 or 0, shape (slots, numbers).

    None takes a number that does not act in the run, nor a calibrated one that a cause's replaces.
    """
    result = np.zeros((count, len(wanted)))
    replaced = {slot for f in overriding if run in f.runs and not f.calibrated for slot in f.slots}
    for j, freed in enumerate(wanted):
        if run in freed.runs and not (freed.calibrated and replaced.intersection(freed.slots)):
            result[freed.slots, j] = 1.0
    return result


def held_at(value: float, number: FreeNumber, items: Iterable[Item]) -> tuple[Item, ...]:
    """Causes in which one of their numbers is held at a value."""
    held = replace(number, lower=value, upper=value)
    swapped = ((each, tuple(held if f is number else f for f in each.freed)) for each in items)
    return tuple(replace(each, freed=freed) for each, freed in swapped)


class Fitter:
    """Fits models to a problem under a noise model of each channel, and what wanders beside its log.

    What the scatter of logged inputs, and not knowing when between two rows they leap, does to the readings
    counts as noise as well.
    """

    def __init__(
        self,
        problem: Problem,
        noise: Sequence[NoiseModel],
        wander: Wander = STILL,
        responses: Responses | None = None,
    ) -> None:
        self.problem, self.noise = problem, tuple(noise)
        self.wander, self.responses = wander, responses
        self.rows = [
            [np.flatnonzero(data.fitted & np.isfinite(column)) for column in data.readings.T]
            for data in problem.data
        ]
        self._whiteners = [
            [Whitener(n, data.time[r]) for n, r in zip(problem.noise_in(run, noise), rows, strict=True)]
            for run, (data, rows) in enumerate(zip(problem.data, self.rows, strict=True))
        ]
        self._smoothing: list[list[Smoothing]] = [[] for _ in problem.data]
        self.count = sum(r.size for rows in self.rows for r in rows)
        self._count_as_noise(problem.scattered)
        self._count_as_noise(problem.leaping)
        if responses is not None and not wander.still:
            self._count_as_noise([c @ responses.root(i, wander) for i, c in enumerate(responses.columns)])

    def _count_as_noise(self, columns: Sequence[Array]) -> None:
        """Whiten for courses of unit variance too, by their columns in each run's readings."""
        for run, each in enumerate(columns):
            if each.shape[2]:
                self._smoothing[run].append(Smoothing(self.whiten(run, self.stacked(run, each))))

    def anew(self) -> Fitter:
        """The same where the problem was last refined."""
        return Fitter(self.problem, self.noise, self.wander, self.responses)

    def stacked(self, run: int, table: Array) -> Array:
        """Rows that are fitted, channel after channel, from a table of shape (rows, channels, ...)."""
        return np.concatenate([table[rows, channel] for channel, rows in enumerate(self.rows[run])])

    def by_channel(self, run: int, stacked: Array) -> list[Array]:
        """The same rows of each channel."""
        return np.split(stacked, np.cumsum([rows.size for rows in self.rows[run]])[:-1])

    def whiten(self, run: int, stacked: Array) -> Array:
        """Whiten columns of a run, shape (rows, columns), channel after channel."""
        pairs = zip(self._whiteners[run], self.by_channel(run, stacked), strict=True)
        white = np.concatenate([whiten(each) for whiten, each in pairs])
        for smoothing in self._smoothing[run]:
            white = smoothing(white)
        return white

    def whitened(self, freed: Numbers, theta: Array, every: bool = False) -> list[Array]:
        """Whitened residual of each run, beside it the derivatives by slot, channel after channel.

        They are by the slots of the freed numbers, the others' 0, or else by every slot.
        """
        result = []
        for run, data in enumerate(self.problem.data):
            z = self.problem.values(run, freed, theta)
            values, by_slot = self.problem.predict(run, z, None if every else freed)
            joined = np.concatenate([(data.readings - values)[:, :, None], by_slot], axis=2)
            result.append(self.whiten(run, self.stacked(run, joined)))
        return result

    def at(self, freed: Numbers, theta: Array, every: bool = True) -> FitPoint:
        """Chi-square and its linearisation at given values, by every slot or those of the freed numbers."""
        return FitPoint.of([each.T @ each for each in self.whitened(freed, theta, every)])

    def fit(
        self, items: Sequence[Item], start: dict[FreeNumber, float] | None = None, worth: float = np.inf
    ) -> Fit:
        """Fit a model, from given values as far as there are any.

        The fit is given up where its linearisation, some steps on, promises no chi-square below what makes it
        `worth` more.
        """
        freed = (*self.problem.calibrated, *(f for item in items for f in item.freed))
        theta = np.array([(start or {}).get(f, f.start) for f in freed])
        lower, upper, neutral = _bounds(freed)
        theta = np.clip(theta, lower, upper)
        every = not freed
        begun = self._tried(freed, theta, every)
        theta = neutral if begun is None else theta
        point = begun or self.at(freed, theta, every)
        evaluations, share = _MOST_EVALUATIONS if freed else 0, 1.0
        while evaluations > 0 and not self.problem.out_of_time():
            gram, gradient = of_numbers(freed, freed, point)
            step, expected = bounded_step(gram, gradient, lower - theta, upper - theta)
            if evaluations <= _MOST_EVALUATIONS - _TRIED and point.chi2 - expected > worth:
                break
            tried, gained, share = None, 0.0, min(1.0, 4 * share)
            while gained <= 0 and share * expected >= self._small(point) and evaluations > 0:
                ahead = np.clip(theta + share * step, lower, upper)  # which rounding may leave
                last = share == 1.0 and expected < _SETTLED
                tried, evaluations = self._tried(freed, ahead, last), evaluations - 1
                if tried is None:
                    share *= 0.1
                    continue
                gained = point.chi2 - tried.chi2
                if gained <= 0:
                    # The least of the parabola through both values with the slope at the first.
                    fall = 2 * share * float(gradient @ step)
                    share *= max(0.1, fall / (2 * (fall - gained)))
            if tried is None or gained <= 0:
                break
            theta, point, every = ahead, tried, last
            if share == 1.0 and abs(gained - expected) < 0.02 * gained and gained < _SETTLED:
                break
        if not every:
            point = self.at(freed, theta)
        arrived = True
        if freed:
            theta, point, arrived = self._last_step(freed, theta, point)
        return Fit(tuple(items), freed, theta, point, self._beyond(freed, theta, point), arrived)

    def _last_step(self, freed: Numbers, theta: Array, point: FitPoint) -> tuple[Array, FitPoint, bool]:
        """Values and point after a last step too small to be worth a simulation; whether it is so small."""
        lower, upper, _ = _bounds(freed)
        step, expected = bounded_step(*of_numbers(freed, freed, point), lower - theta, upper - theta)
        if not 0 < expected < self._small(point):
            return theta, point, expected <= 0
        ahead = np.clip(theta + step, lower, upper)
        return ahead, point.moved(freed, ahead - theta, freed), True

    def _small(self, point: FitPoint) -> float:
        """Decrease of chi-square that is not worth a simulation."""
        return max(_SMALL, _SHARE * (point.chi2 - self.count))

    def _tried(self, freed: Numbers, theta: Array, every: bool) -> FitPoint | None:
        """Chi-square and its linearisation; None where nothing can be simulated with such values."""
        try:
            return self.at(freed, theta, every)
        except NotSimulatedError:
            return None

    def _beyond(self, freed: Numbers, theta: Array, point: FitPoint) -> tuple[bool, ...]:
        """Whether the data insist on a value beyond a bound: the bound costs more than noise would."""
        lower, upper, _ = _bounds(freed)
        on = np.array([f.on_bound(value) for f, value in zip(freed, theta, strict=True)], dtype=bool)
        if not on.any():
            return (False,) * len(freed)
        low, high = np.where(on, -np.inf, lower - theta), np.where(on, np.inf, upper - theta)
        _, beyond = bounded_step(*of_numbers(freed, freed, point), low, high)
        return tuple(bool(each) and beyond > _BEYOND for each in on)


def _bounds(freed: Numbers) -> Array:
    """Lower bounds, upper bounds and starting values, shape (3, numbers)."""
    return np.array([(f.lower, f.upper, f.start) for f in freed]).reshape(-1, 3).T

"""A fitted model: what it leaves, channel by channel, and what it predicts in other runs, and how surely."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import pandas as pd

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.fit.algebra import orthonormal, root_of
from warmlink.orchestration.diagnosis.fit.candidates import FreeNumber
from warmlink.orchestration.diagnosis.fit.fitting import Fit, Fitter, by_number
from warmlink.orchestration.diagnosis.fit.noise import slow_courses
from warmlink.orchestration.diagnosis.fit.patterns import patterns
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.wandering import Responses, Wander

_NOTABLE = 1.5
"""RMSE over noise in a phase from which it counts as wrong."""

_FOLLOWS = 0.5
"""Correlation from which a residual is said to follow a signal."""

_STEADY = 1.0 / 3600
"""K/s below which temperatures count as steady."""

_AFTER = 300.0
"""s after a change of the inputs."""

UNEXPLAINED = 0.001
"""Chance of residuals as slow as those that a model leaves, below which it does not explain the run."""

_FEWEST = 8
"""Readings of a channel in a run whose slow courses are worth a test."""


@dataclass(frozen=True)
class Wrong:
    """Errors of one channel on the fitted rows; values in SI.

    Attributes
    ----------
    rmse, noise, bias : root mean square of measured minus simulated, that of the noise, and mean
    whiteness_p : chance level of residuals as far from white
    when : phases in which it is wrong
    correlates_with : signals that the residual follows, with their correlation, strongest first
    """

    rmse: float
    noise: float
    bias: float
    whiteness_p: float
    when: tuple[str, ...]
    correlates_with: tuple[tuple[str, float], ...]


def residuals_of(problem: Problem, fit: Fit) -> list[Array]:
    """Measured minus simulated by run, shape (rows, outputs)."""
    values = enumerate(problem.values_by_run(fit.freed, fit.theta))
    return [problem.data[run].readings - problem.predict(run, z, ())[0] for run, z in values]


def what_is_wrong(fitter: Fitter, fit: Fit) -> dict[str, Wrong]:
    """Describe a model's errors by column name."""
    problem = fitter.problem
    residuals = residuals_of(problem, fit)
    every = enumerate(fitter.whitened(fit.freed, fit.theta))
    white = [fitter.by_channel(run, joined[:, 0]) for run, joined in every]
    runs = zip(problem.experiment.runs, problem.data, strict=True)
    phases = pd.concat([_phases(run, data.time, data.readings) for run, data in runs]).eq(True)
    signals = pd.concat([_signals(problem, i) for i in range(len(residuals))], join="inner")
    begins = np.cumsum([0, *(len(each) for each in residuals)])
    deviations = np.concatenate([problem.deviations(run, fitter.noise) for run in range(len(residuals))])
    found = {}
    for channel, variable in enumerate(problem.variables):
        rows = [begin + of_run[channel] for begin, of_run in zip(begins, fitter.rows, strict=False)]
        at = np.concatenate(rows)
        residual = np.concatenate(residuals)[at, channel]
        if at.size == 0:
            continue
        noise = deviations[at, channel]
        found[problem.names[variable]] = Wrong(
            _root_mean_square(residual),
            _root_mean_square(noise),
            float(np.mean(residual)),
            _whiteness_p(np.concatenate([each[channel] for each in white])),
            _when(residual / noise, phases.iloc[at]),
            _followed(residual, signals.iloc[at]) if np.std(residual) > _root_mean_square(noise) else (),
        )
    return found


def _root_mean_square(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _phases(run: Run, times: Array, readings: Array) -> pd.DataFrame:
    """Whether each row of a run belongs to each phase."""
    from scipy.ndimage import uniform_filter1d

    table = pd.DataFrame(readings, index=times)
    temperature = table.loc[:, table.mean() > 1].mean(axis=1)  # metres and strokes are small
    filled = temperature.interpolate("index", limit_direction="both").fillna(0.0).to_numpy()
    width = max(3, int(300 / max(float(np.median(np.diff(times))), 1e-9)))
    rate = np.gradient(uniform_filter1d(filled, width, mode="nearest"), times)
    phases = {"heating": rate > _STEADY, "steady": np.abs(rate) <= _STEADY, "cooling": rate < -_STEADY}
    for name, signal in run.inputs.items():
        word, filled = name.partition(".")[2], np.nan_to_num(signal, nan=0.0)
        events = run.time[1:][np.abs(np.diff(filled)) > 0.1 * np.ptp(filled)]
        if 0 < events.size <= 50 and f"after a change of {word}" not in phases:
            since = times[:, None] - events[None, :]
            phases[f"after a change of {word}"] = np.any((since >= 0) & (since < _AFTER), axis=1)
    return pd.DataFrame(phases)


def _when(errors: Array, phases: pd.DataFrame) -> tuple[str, ...]:
    """Phases in which errors, in units of the noise, are notable, worst first."""
    by_phase = {str(name): errors[phase.to_numpy()] for name, phase in phases.items()}
    sizes = {name: np.sqrt(np.mean(each**2)) for name, each in by_phase.items() if each.size >= 10}
    return tuple(name for name in sorted(sizes, key=lambda name: -sizes[name]) if sizes[name] > _NOTABLE)


def _signals(problem: Problem, run: int) -> pd.DataFrame:
    """Signals that a residual may follow, at the rows of a run."""
    data, measured, unit = problem.data[run], problem.experiment.runs[run], problem.experiment.rig.unit
    held = measured.row_at(data.time)
    signals = {"time": data.time}
    for name, signal in {**measured.inputs, **measured.covariates}.items():
        signals.setdefault(name.rpartition(".")[2], signal[held])
    signals.pop("pad_temperature", None)
    columns = zip(problem.variables, data.readings.T, strict=True)
    temperatures = {problem.names[v]: column for v, column in columns if unit(v) == "K"}
    for name, values in temperatures.items():
        signals[name] = values
        if measured.ambient is not None:
            signals[f"{name}^4 - ambient^4"] = values**4 - measured.ambient[held] ** 4
    for (a, first), (b, second) in pairwise(temperatures.items()):
        signals[f"{a} - {b}"] = first - second
    return pd.DataFrame(signals)


def _followed(residual: Array, signals: pd.DataFrame) -> tuple[tuple[str, float], ...]:
    """Signals that a residual follows, with their correlation, strongest first."""
    left = pd.Series(residual, index=signals.index)
    found = [(str(name), float(signal.corr(left, min_periods=11))) for name, signal in signals.items()]
    return tuple(sorted((p for p in found if abs(p[1]) > _FOLLOWS), key=lambda pair: -abs(pair[1]))[:4])


def _whiteness_p(residual: Array) -> float:
    """Chance level of the cumulative periodogram's distance from a straight line (Kolmogorov-Smirnov)."""
    from scipy.fft import dct
    from scipy.special import kolmogorov

    if residual.size < 8:
        return 1.0
    power = dct(residual, norm="ortho")[1:] ** 2
    cumulated = np.cumsum(power) / power.sum()
    straight = np.arange(1, power.size + 1) / power.size
    # The periodogram's squares have two degrees of freedom in a pair of cosines.
    return float(kolmogorov(np.abs(cumulated - straight).max() * np.sqrt(power.size / 2)))


@dataclass(frozen=True)
class Followed:
    """An input that residuals of a channel follow in blocks, and the chance level of that, tests counted."""

    signal: str
    channel: int
    chance: float


class _Left:
    """Whitened residuals of a fit, what it fitted taken out, and how likely noise has so much of courses."""

    def __init__(self, fitter: Fitter, fit: Fit) -> None:
        from scipy.linalg import block_diag

        residuals, courses, sensitivities, self.widths = [], [], [], []
        for run, joined in enumerate(fitter.whitened(fit.freed, fit.theta)):
            residuals.append(joined[:, 0])
            sensitivities.append(by_number(joined[:, 1:], fit.freed, run, fit.freed))
            times = [fitter.problem.data[run].time[rows] for rows in fitter.rows[run]]
            tables = [slow_courses(t) if t.size >= _FEWEST else np.zeros((t.size, 0)) for t in times]
            courses.append(fitter.whiten(run, block_diag(*tables)))
            self.widths += [table.shape[1] for table in tables if table.shape[1]]
        self._taken = orthonormal(np.concatenate(sensitivities))
        self.residual = self.without_fitted(np.concatenate(residuals))
        self.basis = self.without_fitted(block_diag(*courses))
        self.slow = orthonormal(self.basis)
        rest = max(self.residual.size - self.slow.shape[1] - self._taken.shape[1], 1)
        # Half of the rest's degrees of freedom: the noise's correlation was estimated too.
        self._rest = max(rest // 2, 4)

    def without_fitted(self, columns: Array) -> Array:
        """Columns without what the fitted numbers explain, shape as given."""
        return columns - self._taken @ (self._taken.T @ columns)

    def chance(self, courses: Array) -> float:
        """Chance level of so much of orthonormal courses, shape (rows, courses).

        The statistic is an F ratio, since the noise itself is estimated from what is not slow.
        """
        from scipy.special import fdtrc

        chi2, degrees = float(np.sum((courses.T @ self.residual) ** 2)), max(courses.shape[1], 1)
        return float(fdtrc(degrees, self._rest, chi2 / degrees))

    def of_slow_courses(self) -> float:
        """Chance level of the slow courses, all together and in each channel of each run."""
        edges = np.cumsum([0, *self.widths])
        single = min(self.chance(orthonormal(self.basis[:, a:b])) for a, b in pairwise(edges))
        return min(1.0, 2 * min(self.chance(self.slow), len(self.widths) * single))

    def of_patterns(self, fitter: Fitter) -> Followed | None:
        """The input that is followed most, slow courses apart; None where no input changes."""
        tried = patterns(fitter)
        found = []
        for each in tried:
            courses = self.without_fitted(each.courses)
            courses = orthonormal(courses - self.slow @ (self.slow.T @ courses), 1e-3)
            if courses.shape[1]:
                chance = min(1.0, 2 * len(tried) * self.chance(courses))
                found.append(Followed(each.signal, each.channel, chance))
        return min(found, key=lambda each: each.chance, default=None)


def lack_of_fit_p(fitter: Fitter, fit: Fit) -> float:
    """Chance level of what a fit leaves: of slow courses, and of patterns that follow an input in blocks.

    What is wrong with one sensor shows by itself, and is lost among many. The chance level is that of the
    least likely outcome, counted with the number of tests (Bonferroni).
    """
    left = _Left(fitter, fit)
    pattern = left.of_patterns(fitter)
    return min(left.of_slow_courses(), 1.0 if pattern is None else pattern.chance)


def followed_input(fitter: Fitter, fit: Fit) -> Followed | None:
    """The input that a fit's residuals follow in blocks, if that is no chance."""
    found = _Left(fitter, fit).of_patterns(fitter)
    return found if found is not None and found.chance < UNEXPLAINED else None


Weighed = Callable[[Array], Array]
"""Function that makes fewer outputs of a table with an axis of outputs, the second, or leaves them."""


def same(table: Array) -> Array:
    """The table as it is."""
    return table


class Carried:
    """A fitted model carried over to a problem with other runs.

    A group that was never fitted takes the mean of those that were.

    Parameters
    ----------
    problem : with the same candidates
    fit : the model
    plant_only : leave out causes in logs and instruments, which are wrong in the fitted runs alone

    The model's numbers in the problem are `freed`, its slots by run `values`, shape (slots,) each; the
    machine that has them is that of its `experiment`.
    """

    def __init__(self, problem: Problem, fit: Fit, plant_only: bool = False) -> None:
        self.fit, self._problem, self.experiment = fit, problem, problem.experiment
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
        self._there = {f.key: f for f in problem.numbers}
        self._predicted: dict[int, tuple[Array, Array]] = {}

    def predict(self, run: int) -> tuple[Array, Array]:
        """Readings of a run and their derivatives by slot, as the problem gives them."""
        if run not in self._predicted:
            self._predicted[run] = self._problem.predict(run, self.values[run])
        return self._predicted[run]

    def by(self, run: int, numbers: Sequence[FreeNumber]) -> Array:
        """Derivatives of a run's readings by numbers of another problem, shape (rows, outputs, numbers)."""
        wanted = [self._there.get(f.key, replace(f, runs=())) for f in numbers]
        return by_number(self.predict(run)[1], wanted, run, self.freed)

    def variance(self, run: int, weighed: Weighed = same) -> Array:
        """Of a run's readings, for how uncertain the fitted numbers are, shape (rows, outputs).

        `weighed` adds up outputs of the readings' derivatives, shape (rows, outputs, numbers).
        """
        columns = weighed(self.by(run, self.fit.freed)) @ root_of(self.fit.covariance())
        return np.asarray(np.sum(columns**2, axis=-1))

    def wandering(self, run: int, wander: Wander, weighed: Weighed = same) -> Array:
        """Variance of a run's readings for what wanders beside its log, shape (rows, outputs)."""
        if wander.still:
            return np.zeros(weighed(self.predict(run)[0]).shape)
        columns = weighed(self._responses.columns[run]) @ self._responses.root(run, wander)
        return np.asarray(np.sum(columns**2, axis=-1))

    @cached_property
    def _responses(self) -> Responses:
        return Responses(self._problem, self.values)

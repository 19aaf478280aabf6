"""What the simulation gets wrong, channel by channel: how much, when, and what the error follows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.fit.fitting import Fit, Fitter
from warmlink.orchestration.diagnosis.fit.lack_of_fit import whiteness_p
from warmlink.orchestration.diagnosis.fit.problem import Problem

_NOTABLE = 1.5
"""RMSE over noise in a phase from which it counts as wrong."""

_FOLLOWS = 0.5
"""Correlation from which a residual is said to follow a signal."""

_STEADY = 1.0 / 3600
"""K/s below which temperatures count as steady."""

_AFTER = 300.0
"""s after a change of the inputs."""


@dataclass(frozen=True)
class Wrong:
    """Errors of one channel on the fitted rows; values in SI.

    Attributes
    ----------
    rmse, noise, bias : root mean square of measured minus simulated, noise, and mean
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
    return [
        data.readings - problem.predict(run, problem.values(run, fit.freed, fit.theta))[0]
        for run, data in enumerate(problem.data)
    ]


def what_is_wrong(fitter: Fitter, fit: Fit) -> dict[str, Wrong]:
    """Describe a model's errors by column name."""
    problem = fitter.problem
    residuals = residuals_of(problem, fit)
    whitened = fitter.whitened(fit.freed, fit.theta)
    phases = [
        _phases(run, data.time, data.readings)
        for run, data in zip(problem.experiment.runs, problem.data, strict=True)
    ]
    signals = [_signals(problem, i) for i in range(len(problem.data))]
    found = {}
    for channel, variable in enumerate(problem.variables):
        rows = [fitter.rows[run][channel] for run in range(len(residuals))]
        parts = [r[k, channel] for r, k in zip(residuals, rows, strict=True)]
        together = np.concatenate(parts)
        if together.size == 0:
            continue
        by_run = [problem.noise_in(run, fitter.noise)[channel].sigma for run in range(len(parts))]
        noise = float(np.sqrt(np.average(np.square(by_run), weights=[r.size for r in rows])))
        white = np.concatenate([w[channel][:, 0] for w in whitened])
        found[problem.names[variable]] = Wrong(
            float(np.sqrt(np.mean(together**2))),
            noise,
            float(np.mean(together)),
            whiteness_p(white),
            _when(parts, rows, phases, noise),
            _followed(parts, rows, signals) if np.std(together) > noise else (),
        )
    return found


def _phases(run: Run, times: Array, readings: Array) -> dict[str, NDArray[np.bool_]]:
    """Rows of each phase of a run."""
    full = np.isfinite(readings)
    temperatures = full.any(axis=0) & (np.nansum(readings, axis=0) > full.sum(axis=0))
    counted, sums = full[:, temperatures].sum(axis=1), np.nansum(readings[:, temperatures], axis=1)
    without = np.full(times.size, np.nan if temperatures.any() else 0.0)
    mean = np.divide(sums, counted, out=without, where=counted > 0)
    filled = (
        np.interp(times, times[np.isfinite(mean)], mean[np.isfinite(mean)])
        if np.isfinite(mean).any()
        else mean
    )
    width = max(3, int(300 / max(float(np.median(np.diff(times))), 1e-9)))
    smooth = np.convolve(np.pad(filled, width // 2, mode="edge"), np.ones(width) / width, "valid")[
        : times.size
    ]
    rate = np.gradient(smooth, times)
    phases = {"heating": rate > _STEADY, "steady": np.abs(rate) <= _STEADY, "cooling": rate < -_STEADY}
    for name, signal in run.inputs.items():
        word = name.partition(".")[2]
        events = _changes(run.time, signal)
        if 0 < events.size <= 50 and f"after a change of {word}" not in phases:
            since = times[:, None] - events[None, :]
            phases[f"after a change of {word}"] = np.any((since >= 0) & (since < _AFTER), axis=1)
    return phases


def _changes(times: Array, signal: Array) -> Array:
    filled = np.nan_to_num(signal, nan=0.0)
    span = float(np.ptp(filled))
    return times[1:][np.abs(np.diff(filled)) > 0.1 * span] if span > 0 else times[:0]


def _when(
    parts: Sequence[Array],
    rows: Sequence[NDArray[np.int64]],
    phases: Sequence[Mapping[str, NDArray[np.bool_]]],
    noise: float,
) -> tuple[str, ...]:
    sizes = {}
    for name in dict.fromkeys(name for each in phases for name in each):
        chosen = [
            part[phase[name][row]]
            for part, row, phase in zip(parts, rows, phases, strict=True)
            if name in phase
        ]
        values = np.concatenate(chosen)
        if values.size >= 10:
            sizes[name] = float(np.sqrt(np.mean(values**2))) / noise
    wrong = [name for name, size in sizes.items() if size > _NOTABLE]
    return tuple(sorted(wrong, key=lambda name: -sizes[name]))


def _signals(problem: Problem, run: int) -> dict[str, Array]:
    """Signals that a residual may follow, at the rows of a run."""
    data, measured = problem.data[run], problem.experiment.runs[run]
    held = measured.row_at(data.time)
    signals = {"time": data.time}
    for name, signal in {**measured.inputs, **measured.covariates}.items():
        word = name.rpartition(".")[2]
        if word != "pad_temperature":
            signals.setdefault(word, signal[held])
    temperatures = {
        problem.names[v]: data.readings[:, i]
        for i, v in enumerate(problem.variables)
        if problem.experiment.rig.unit(v) == "K"
    }
    for name, values in temperatures.items():
        signals[name] = values
        if measured.ambient is not None:
            signals[f"{name}^4 - ambient^4"] = values**4 - measured.ambient[held] ** 4
    pairs = list(temperatures.items())
    for (a, first), (b, second) in pairwise(pairs):
        signals[f"{a} - {b}"] = first - second
    return signals


def _followed(
    parts: Sequence[Array], rows: Sequence[NDArray[np.int64]], signals: Sequence[Mapping[str, Array]]
) -> tuple[tuple[str, float], ...]:
    residual = np.concatenate(parts)
    found = []
    for name in signals[0]:
        if any(name not in each for each in signals):
            continue
        signal = np.concatenate([each[name][row] for each, row in zip(signals, rows, strict=True)])
        good = np.isfinite(signal)
        if good.sum() > 10 and np.std(signal[good]) > 0 and np.std(residual[good]) > 0:
            r = float(np.corrcoef(signal[good], residual[good])[0, 1])
            if abs(r) > _FOLLOWS:
                found.append((name, r))
    return tuple(sorted(found, key=lambda pair: -abs(pair[1]))[:4])

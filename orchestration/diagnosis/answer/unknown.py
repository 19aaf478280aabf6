"""What an unknown cause looks like: terms that missing heat follows, and when heat is missing.

A hint, not a finding. The balance is taken over stretches of time (a weak form, so that no noisy
derivative is needed), and terms are added one by one while they still explain a good part of it, as in
sparse identification of dynamics (S. L. Brunton, J. L. Proctor, J. N. Kutz, PNAS 113 (2016) 3932).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.fitted import residuals_of
from warmlink.orchestration.diagnosis.fit.likeliest import Integrated
from warmlink.orchestration.diagnosis.fit.verdict import Assessment
from warmlink.orchestration.diagnosis.fit.wandering import Responses, Wander

_STRETCH = 300.0
"""s of a balance."""

_MOST_TERMS = 2
_WORTH = 0.15
"""Share of the missing heat's variance that a term must explain."""

_HEATS = tuple(0.1 * 2.0**k for k in range(10))
"""W, standard deviations of the course of missing heat that are tried."""


@dataclass(frozen=True)
class Hint:
    """Terms that the missing rate of warming of the channel with the largest unexplained course follows.

    Each term is its name and `coefficient` in K/s per unit of it; the share is what they explain of the
    missing rate's variance.
    """

    channel: str
    terms: tuple[Mapping[str, str | float], ...]
    explained_share: float

    @property
    def sentence(self) -> str:
        """Say what it looks like."""
        if not self.terms:
            return f"what is missing in {self.channel} follows no single physical term."
        looks = " and ".join(str(each["term"]) for each in self.terms)
        share = f"{100 * self.explained_share:.0f} % of its course"
        return f"what is missing in {self.channel} looks like {looks} ({share})."


@dataclass(frozen=True)
class MissingHeat:
    """The smoothest heat input into the shaft, in W, that would explain what is left of one run.

    At times in s, with its standard deviation, shape (nodes,) each.
    """

    run: str
    time: Array
    heat: Array
    deviation: Array

    @property
    def sentence(self) -> str:
        """Say when most heat is missing, or too much is made."""
        k = int(np.argmax(np.abs(self.heat)))
        way = "more" if self.heat[k] > 0 else "less"
        return (
            f"heat into the shaft would have to be {abs(self.heat[k]):.2g} W {way} at "
            f"{self.time[k] / 60:.0f} min of {self.run} (95 %: within {1.96 * self.deviation[k]:.2g} W)."
        )


def missing_heat(assessment: Assessment) -> tuple[MissingHeat, ...]:
    """The course by fitted run, in the model as it stands; none in a system without a motor."""
    problem, fit = assessment.problem, assessment.null
    responses = Responses(problem, problem.values_by_run(fit.freed, fit.theta))
    if "heat" not in responses.signals:
        return ()
    seen = Integrated(assessment.search, fit, responses)
    wander = min((Wander(heat=heat) for heat in _HEATS), key=seen.misfit_alone)
    found = []
    for run in problem.fitted_runs:
        mean, covariance = seen.smoothed(run, wander)
        nodes = responses.nodes[run]
        heat = slice(mean.size - nodes.size, None)
        deviation = np.sqrt(np.diag(covariance))[heat]
        found.append(MissingHeat(problem.experiment.runs[run].name, nodes, mean[heat], deviation))
    return tuple(found)


def hint(assessment: Assessment) -> Hint | None:
    """Look for physical terms in what the uncorrected model misses; None where too little is measured."""
    problem = assessment.problem
    residuals = residuals_of(problem, assessment.null)
    size = np.sqrt(np.nanmean(np.concatenate(residuals) ** 2, axis=0))
    sizes = size / [noise.sigma for noise in assessment.noise]
    if not np.isfinite(sizes).any():
        return None
    channel = int(np.nanargmax(sizes))
    targets, tables = [], []
    for run, residual in enumerate(residuals):
        times = problem.data[run].time
        edges = np.arange(0.0, times[-1], _STRETCH)
        good = np.isfinite(residual[:, channel])
        if edges.size >= 6 and good.sum() >= 6:
            targets.append(np.diff(_means(times[good], residual[good, channel], edges)) / _STRETCH)
            tables.append(_terms(assessment, run, times, edges))
    if not targets:
        return None
    chosen, share = _selected(np.concatenate(targets), pd.concat(tables, join="inner"))
    told = tuple(dict[str, str | float](term=name, coefficient=value) for name, value in chosen.items())
    return Hint(problem.names[problem.variables[channel]], told, share)


def _means(times: Array, values: Array, edges: Array) -> Array:
    """Means over stretches; an empty one is interpolated."""
    means = pd.Series(values).groupby(np.digitize(times, edges) - 1).mean()
    return means.reindex(range(edges.size)).interpolate(limit_direction="both").to_numpy()


def _terms(assessment: Assessment, run: int, times: Array, edges: Array) -> pd.DataFrame:
    """Candidate terms as means between the middles of successive stretches."""
    problem = assessment.problem
    measured, data = problem.experiment.runs[run], problem.data[run]
    held = measured.row_at(times)
    signals: dict[str, Array] = {
        "a constant heat": np.ones(times.size),
        "heat growing with time": times / 3600,
    }
    for name, values in measured.inputs.items():
        word = name.rpartition(".")[2]
        if word in ("speed", "torque", "current"):
            signals[word] = np.abs(values[held])
            signals[f"{word} squared"] = values[held] ** 2
        if word == "speed":
            signals["speed cubed"] = np.abs(values[held]) ** 3
    for variable, values in zip(problem.variables, data.readings.T, strict=True):
        if problem.experiment.rig.unit(variable) == "K" and measured.ambient is not None:
            rise = values - measured.ambient[held]
            name = problem.names[variable]
            signals[f"loss in proportion to {name} above ambient"] = rise
            signals[f"natural convection at {name}"] = np.sign(rise) * np.abs(rise) ** 1.25
    result = {}
    for name, signal in signals.items():
        good = np.isfinite(signal)
        if good.sum() > 6:
            means = _means(times[good], signal[good], edges)
            result[name] = (means[1:] + means[:-1]) / 2
    return pd.DataFrame(result)


def _selected(target: Array, terms: pd.DataFrame) -> tuple[dict[str, float], float]:
    """Coefficients of the terms that are worth it, and the share of the target that they explain."""
    total = float(target @ target)
    chosen: dict[str, float] = {}
    explained = 0.0
    while len(chosen) < _MOST_TERMS and total > 0:
        tried = {}
        for name in [n for n in map(str, terms) if n not in chosen]:
            table = terms[[*chosen, name]].to_numpy()
            coefficients = np.linalg.lstsq(table, target, rcond=None)[0]
            left = float(np.sum((target - table @ coefficients) ** 2))
            tried[name] = 1 - left / total, coefficients
        best = max(tried, key=lambda n: tried[n][0])
        if tried[best][0] - explained < _WORTH:
            break
        explained, coefficients = tried[best]
        chosen = dict(zip((*chosen, best), map(float, coefficients), strict=True))
    return chosen, explained

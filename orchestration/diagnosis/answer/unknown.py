"""What an unknown cause looks like: the heat missing from a balance, regressed on physical terms.

A hint, not a finding. The balance is taken over stretches of time (a weak form, so that no noisy
derivative is needed), and terms are added one by one while they still explain a good part of it, as in
sparse identification of dynamics (S. L. Brunton, J. L. Proctor, J. N. Kutz, PNAS 113 (2016) 3932).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.residuals import residuals_of
from warmlink.orchestration.diagnosis.fit.verdict import Assessment

_STRETCH = 300.0
"""s of a balance."""

_MOST_TERMS = 2
_WORTH = 0.15
"""Share of the missing heat's variance that a term must explain."""


@dataclass(frozen=True)
class Hint:
    """Terms that the missing rate of warming of one channel follows.

    Attributes
    ----------
    channel : column with the largest unexplained course
    terms : physical terms with their coefficients in K/s per unit of the term
    share : share of the missing rate's variance that they explain
    """

    channel: str
    terms: tuple[tuple[str, float], ...]
    share: float

    @property
    def sentence(self) -> str:
        """Say what it looks like."""
        if not self.terms:
            return f"what is missing in {self.channel} follows no single physical term."
        words = " and ".join(name for name, _ in self.terms)
        return (
            f"what is missing in {self.channel} looks like {words} ({100 * self.share:.0f} % of its course)."
        )

    def to_json(self) -> dict[str, Any]:
        """Entry of `diagnosis.json`."""
        return {
            "channel": self.channel,
            "terms": [{"term": name, "coefficient": value} for name, value in self.terms],
            "explained_share": self.share,
            "sentence": self.sentence,
        }


def hint(assessment: Assessment) -> Hint | None:
    """Look for physical terms in what the uncorrected model misses; None where too little is measured."""
    problem = assessment.problem
    residuals = residuals_of(problem, assessment.null)
    sizes = [
        np.sqrt(np.nanmean(np.concatenate([r[:, i] for r in residuals]) ** 2)) / noise.sigma
        for i, noise in enumerate(assessment.noise)
    ]
    if not np.isfinite(sizes).any():
        return None
    channel = int(np.nanargmax(sizes))
    targets, tables = [], []
    for run, residual in enumerate(residuals):
        times = problem.data[run].time
        edges = np.arange(0.0, times[-1], _STRETCH)
        good = np.isfinite(residual[:, channel])
        if edges.size < 6 or good.sum() < 6:
            continue
        smooth = _means(times[good], residual[good, channel], edges)
        targets.append(np.diff(smooth) / _STRETCH)
        tables.append(_terms(assessment, run, times, edges))
    if not targets:
        return None
    return _selected(problem.names[problem.variables[channel]], np.concatenate(targets), tables)


def _means(times: Array, values: Array, edges: Array) -> Array:
    """Means over stretches; an empty one is interpolated."""
    which = np.digitize(times, edges) - 1
    means = np.array([values[which == i].mean() if np.any(which == i) else np.nan for i in range(edges.size)])
    known = np.isfinite(means)
    return np.interp(np.arange(means.size), np.flatnonzero(known), means[known])


def _terms(assessment: Assessment, run: int, times: Array, edges: Array) -> dict[str, Array]:
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
    for i, variable in enumerate(problem.variables):
        values = data.readings[:, i]
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
    return result


def _selected(channel: str, target: Array, tables: list[dict[str, Array]]) -> Hint:
    names = [n for n in tables[0] if all(n in t for t in tables)]
    columns = {n: np.concatenate([t[n] for t in tables]) for n in names}
    total = float(target @ target)
    chosen: list[str] = []
    explained = 0.0
    coefficients = np.zeros(0)
    while len(chosen) < _MOST_TERMS and total > 0:
        gains = {}
        for name in names:
            if name not in chosen:
                table = np.column_stack([columns[n] for n in (*chosen, name)])
                fitted = table @ np.linalg.lstsq(table, target, rcond=None)[0]
                gains[name] = 1 - float(np.sum((target - fitted) ** 2)) / total
        best = max(gains, key=lambda n: gains[n])
        if gains[best] - explained < _WORTH:
            break
        chosen.append(best)
        explained = gains[best]
        coefficients = np.linalg.lstsq(np.column_stack([columns[n] for n in chosen]), target, rcond=None)[0]
    return Hint(channel, tuple(zip(chosen, map(float, coefficients), strict=True)), explained)

"""What models predict of the whole experiment, and the gate that every verdict passes: the held-out rows.

A cause that is right holds in rows that it was not fitted to; README.md says how errors there are judged.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.measured import names_of
from warmlink.orchestration.diagnosis.fit.candidates import FreeNumber
from warmlink.orchestration.diagnosis.fit.fitted import Carried
from warmlink.orchestration.diagnosis.fit.fitting import Fit, by_number
from warmlink.orchestration.diagnosis.fit.noise import NoiseModel
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.verdict import Word
from warmlink.orchestration.diagnosis.fit.wandering import STILL, Wander

_BLOCK, _RESAMPLES = 600.0, 400
"""s of a block in the bootstrap, longer than the noise remembers; and how often blocks are drawn."""

_OFF, MISSED = 3.0, 1.5
"""Error over its band from which a model does not predict, and from which it tells of no cause."""

_GROWN, _HALVED = 1.1, 0.5
"""Ratio to the error before from which a model is worse, and much better."""

_EXCESS, _LEFT = 0.44, 1 / 3
"""Mean square of the errors beyond that of the noise, in units of the noise: what chance may leave, and what
a right cause may leave as a share of what it was before. A wrong cause fits the fitted rows alone."""

_FAR = 10.0
"""Error over noise beyond which a model predicts nothing, however much better it is than another."""

_CLOSE = 1.5
"""Ratio of an error to that at which the verdict changes, within which a search's last digits may decide."""

_SHARE, _NORMAL = 0.8, 1.2816
"""Quantile of the absolute errors that is looked at, and its value for normal ones of unit variance."""

_FEWEST = 10

_OUTSIDE = 0.1
"""Share of held-out rows outside the fitted range from which that is told."""


@dataclass(frozen=True)
class Predicted:
    """Readings by one model, by run in SI, shape (rows, outputs)."""

    model: Carried
    readings: tuple[Array, ...]

    @property
    def fit(self) -> Fit:
        """The model's fit."""
        return self.model.fit


@dataclass(frozen=True)
class HeldOut:
    """Errors of a model on held-out rows, robust against rows that are off by far.

    `over_band` is the largest of the runs by column name, as a multiple of what is known to remain;
    `in_noise` the root mean square of all channels, in units of their noise.
    """

    over_band: Mapping[str, float]
    in_noise: float

    @property
    def excess(self) -> float:
        """Mean square beyond that of the noise, in its units."""
        return self.in_noise**2 - 1

    @property
    def worst(self) -> tuple[float, str]:
        """Largest error over its band, and its column."""
        return max((over, name) for name, over in self.over_band.items())


class Scores:
    """Errors of models on a whole experiment, held-out rows included.

    They are added by `scales`, the noise of each reading in SI, by run, shape (rows, outputs): the stated
    figure if there is one, else the estimate as far as the readings' scatter makes it credible, and by the
    `best` model's values what it does to a reading that nobody knows when between two rows the inputs leapt.
    """

    def __init__(self, problem: Problem, noise: Sequence[NoiseModel], best: Fit) -> None:
        self.problem = problem
        self.scales: list[Array] = []
        self._doubted: list[list[bool]] = []
        for run, z in enumerate(Carried(self.problem, best).values):
            leaps = np.sum(self.problem.switched(run, z) ** 2, axis=2)
            told = self.problem.reported_noise(run, noise)
            self.scales.append(np.sqrt(told**2 + leaps))
            here = self.problem.noise_in(run, noise)
            self._doubted.append([size < 0.99 * each.sigma for size, each in zip(told, here, strict=True)])

    def predict(self, fit: Fit) -> Predicted:
        """Readings of every run by a model fitted elsewhere."""
        model, runs = Carried(self.problem, fit), range(len(self.problem.data))
        return Predicted(model, tuple(self.problem.finest(i, self._adapted(i, model)) for i in runs))

    def rmse(self, predicted: Predicted, heldout: bool) -> tuple[float, float, float] | None:
        """RMSE in units of noise over fitted or held-out rows, and its 95 % interval."""
        runs = zip(self.problem.data, predicted.readings, self.scales, strict=True)
        squares = [
            pd.DataFrame(((data.readings - read) / scale) ** 2, np.floor(data.time / _BLOCK))
            for data, read, scale in runs
        ]
        rows = np.concatenate([data.fitted != heldout for data in self.problem.data])
        blocks = pd.concat(squares, keys=range(len(squares)))[rows].groupby(level=[0, 1])
        table = np.column_stack([blocks.sum().sum(axis=1), blocks.count().sum(axis=1)])
        table = table[table[:, 1] > 0]
        if not table.size:
            return None
        drawn = np.random.default_rng(0).integers(0, len(table), (_RESAMPLES, len(table)))
        resampled = np.sqrt(table[drawn, 0].sum(axis=1) / table[drawn, 1].sum(axis=1))
        low, high = np.quantile(resampled, [0.025, 0.975])
        return float(np.sqrt(table[:, 0].sum() / table[:, 1].sum())), float(low), float(high)

    def by_channel(self, predicted: Predicted) -> list[dict[str, float]]:
        """RMSE in SI by run and column name."""
        result = []
        for data, readings in zip(self.problem.data, predicted.readings, strict=True):
            errors = zip(self.problem.names.values(), (data.readings - readings).T, strict=True)
            read = ((name, error) for name, error in errors if np.isfinite(error).any())
            result.append({name: float(np.sqrt(np.nanmean(error**2))) for name, error in read})
        return result

    def fitted(self, predicted: Predicted) -> float:
        """Root mean square of the errors on fitted rows in units of the noise, robust as on held-out rows."""
        found = self.held_out(predicted, STILL, heldout=False)
        return 0.0 if found is None else found.in_noise

    def beyond(self, predicted: Predicted) -> dict[str, float]:
        """Error on fitted rows by column name in units of the noise, robust, where that is beyond it.

        Only of channels whose noise is less than what a model leaves: it is stated, or not to be believed.
        """
        found: dict[str, float] = {}
        for run, data in enumerate(self.problem.data):
            error = (data.readings - predicted.readings[run]) / self.scales[run]
            for i, name in enumerate(self.problem.names.values()):
                there = data.fitted & np.isfinite(error[:, i])
                if self._doubted[run][i] and there.sum() >= _FEWEST:
                    found[name] = max(_typical(error[there, i]), found.get(name, 0.0))
        return {name: over for name, over in found.items() if over > MISSED}

    def held_out(self, predicted: Predicted, wander: Wander, heldout: bool = True) -> HeldOut | None:
        """Errors of a model on held-out rows, or else on fitted ones; None where there are too few."""
        problem, model = self.problem, predicted.model
        over_band: dict[str, float] = {}
        squares = []
        for run, data in enumerate(problem.data):
            rows = data.fitted != heldout
            if rows.sum() < _FEWEST:
                continue
            error, scale = (data.readings - predicted.readings[run])[rows], self.scales[run][rows]
            variance = scale**2 + model.variance(run)[rows] + model.wandering(run, wander)[rows]
            for i, name in enumerate(problem.names.values()):
                there = np.isfinite(error[:, i])
                if there.sum() >= _FEWEST:
                    over = _typical(error[there, i] / np.sqrt(variance[there, i]))
                    over_band[name] = max(over, over_band.get(name, 0.0))
                    squares.append(_typical(error[there, i] / scale[there, i]) ** 2)
        return HeldOut(over_band, float(np.sqrt(np.mean(squares)))) if squares else None

    def idle_adaptions(self, predicted: Predicted) -> tuple[str, ...]:
        """Sentences on runs whose `adapt` changes nothing, by a model."""
        return tuple(
            f"{run.name}: adapt = {run.adapt:g} s changes nothing, as no number of the model is this run's "
            'own; start from measurements (initial = "measured"), or calibrate one with per = "run"'
            for i, run in enumerate(self.problem.experiment.runs)
            if run.adapt > 0 and run.heldout and not self._own(i, predicted.model)
        )

    @staticmethod
    def _own(run: int, model: Carried) -> list[FreeNumber]:
        """Numbers of a model that belong to one run alone and were not fitted."""
        fitted = {(f.variable, f.group) for f in model.fit.freed}
        return [f for f in model.freed if f.runs == (run,) and (f.variable, f.group) not in fitted]

    def _adapted(self, run: int, model: Carried) -> Array:
        """Slots of a run; the numbers that belong to a held-out one alone are fitted to its first part."""
        z, own = model.values[run].copy(), self._own(run, model)
        measured, data = self.problem.experiment.runs[run], self.problem.data[run]
        rows = data.time <= measured.adapt
        for _ in range(4 if own and measured.heldout and measured.adapt > 0 else 0):
            _, by_slot = self.problem.predict(run, z)
            residual = ((data.readings - self.problem.finest(run, z)) / self.scales[run])[rows]
            columns = by_number(by_slot[rows], own, run, ()) / self.scales[run][rows, :, None]
            good = np.isfinite(residual)
            step = np.linalg.lstsq(columns[good], residual[good], rcond=None)[0]
            for f, change in zip(own, step, strict=True):
                slots = list(f.slots)
                nothing = self.problem.neutral[run][slots] if f.added else 0.0
                z[slots] = np.clip(z[slots] + change, nothing + f.lower, nothing + f.upper)
        return z


def _typical(errors: Array) -> float:
    return float(np.quantile(np.abs(errors), _SHARE)) / _NORMAL


def verdict_after_holdout(
    word: Word,
    before: HeldOut | None,
    after: Sequence[HeldOut | None],
    fitted: float = 1.0,
    beyond: str = "",
) -> tuple[Word, str]:
    """Verdict after the gate, and why it differs from the one before or what else must be said of it.

    The `word` is the verdict on fitted rows, where the chosen model's error is `fitted` times the noise; the
    other errors are those of the uncorrected model, and of the chosen one and its rivals. `beyond` says where
    its error is beyond a noise that is stated, or that the readings themselves show.
    """
    if word == "adequate" and beyond:
        return "unknown", beyond
    if word != "unknown" and fitted > MISSED:
        still = f"the error on fitted rows is {fitted:.2g} times the noise"
        if word == "adequate":
            return "unknown", f"Only surroundings that wander would explain the run: {still}."
        return "empirical", f"The model may predict better and the cause is not established: {still}."
    if before is None or None in after:
        return word, ""
    every = [each for each in after if each is not None]
    over, name = before.worst
    if word == "adequate" and over > _OFF:
        return "unknown", (
            "The model is adequate for the fitted run and does not predict the held-out one, where "
            f"{name} is off by {over:.1f} times what is known to remain."
        )
    best = every[0]
    change = f"from {before.in_noise:.2g} to {best.in_noise:.2g} times the noise"
    left, grown = max(_EXCESS, _LEFT * before.excess), _GROWN * before.in_noise
    if word in ("named", "ambiguous") and all(e.excess > left or e.in_noise > grown for e in every):
        said = "The error on held-out rows {} {}, so the cause is not established."
        if min(e.in_noise for e in every) > before.in_noise:
            return "unknown", said.format("grows", change)
        went = "grows" if best.in_noise > before.in_noise else "falls only"
        return "empirical", said.format(went, change)
    over, name = best.worst
    if word == "named" and (over > MISSED or best.in_noise > _OFF):
        off = (
            f"{name} is off by {over:.1f} times what is known to remain"
            if over > MISSED
            else (f"the error is still {best.in_noise:.2g} times the noise")
        )
        return "empirical", (
            f"The model predicts better and the cause is not established: on held-out rows {off}."
        )
    if word == "unknown":
        return _unexplained(before.in_noise, best.in_noise, change)
    return word, ""


def _unexplained(before: float, after: float, change: str) -> tuple[Word, str]:
    """Verdict where no causes explain the fitted rows, by what the nearest ones change on held-out rows.

    The search for these ends where its fits are cut short, so that the last digits of the steps may choose
    others. What is near the limit is told as such, under either verdict.
    """
    limit = min(_HALVED * before, _FAR)
    said = f"No cause is established, but with the nearest ones the error on held-out rows falls {change}"
    close = f"; {limit:.2g} times is where unknown becomes empirical, so that this is a close call"
    if after < limit:
        return "empirical", f"{said}{close if after > limit / _CLOSE else ''}."
    return "unknown", f"{said}{close}." if after < min(_CLOSE * limit, before) else ""


def difference(experiment: Experiment) -> str:
    """What differs most between fitted and held-out rows, and the advice that follows."""
    fitted = [r.part(r.fitted) for r in experiment.runs if not r.heldout]
    heldout = [r if r.heldout else r.part(r.time >= r.fit_until) for r in experiment.runs]
    names = names_of(experiment.columns)
    found = []
    for name in {**fitted[0].inputs, **fitted[0].readings}:
        first, then = (
            np.concatenate([{**run.inputs, **run.readings}.get(name, np.empty(0)) for run in runs])
            for runs in (fitted, heldout)
        )
        first, then = first[np.isfinite(first)], then[np.isfinite(then)]
        if first.size and then.size:
            outside = float(np.mean((then < first.min()) | (then > first.max())))
            found.append((outside, names.get(name, name)))
    outside, name = max(found, default=(0.0, ""))
    told = f"{name} lies outside its fitted range in {100 * outside:.0f} % of the held-out rows. "
    return (
        f"{told if outside > _OUTSIDE else ''}Fit all of it together, so that the model has to explain both."
    )

"""The improvement: errors before and after on fitted and on held-out rows, for each model in question."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.fit.carried import Carried
from warmlink.orchestration.diagnosis.fit.fitting import Fit, by_number
from warmlink.orchestration.diagnosis.fit.noise import NoiseModel
from warmlink.orchestration.diagnosis.fit.problem import Freed, Problem

_BLOCK = 600.0
"""s of a block in the bootstrap: longer than the noise remembers."""

_RESAMPLES = 400


@dataclass(frozen=True)
class Predicted:
    """Readings by one model.

    Attributes
    ----------
    name : titles of its causes, or "" for the uncorrected model
    readings : by run, SI, shape (rows, outputs)
    """

    name: str
    readings: tuple[Array, ...]


class Scores:
    """Errors of models on a whole experiment, held-out rows included."""

    def __init__(self, experiment: Experiment, noise: Sequence[NoiseModel]) -> None:
        self.problem = Problem(experiment)
        self.scales = [np.array(_scales(noise, self.problem, i)) for i in range(len(experiment.runs))]

    def predict(self, fit: Fit) -> Predicted:
        """Readings of every run by a model fitted elsewhere."""
        carried = Carried(self.problem, fit)
        values = carried.values
        for run, measured in enumerate(self.problem.experiment.runs):
            if measured.heldout and measured.adapt > 0:
                values[run] = self._adapted(run, values[run], carried.freed, fit, measured.adapt)
        readings = tuple(self.problem.finest(i, z) for i, z in enumerate(values))
        return Predicted(fit.name, readings)

    def rmse(self, predicted: Predicted, heldout: bool) -> tuple[float, float, float] | None:
        """RMSE in units of noise over fitted or held-out rows, and its 95 % interval."""
        blocks = []
        for run, data in enumerate(self.problem.data):
            rows = ~data.fitted if heldout else data.fitted
            error = (data.readings - predicted.readings[run])[rows] / self.scales[run]
            which = np.floor(data.time[rows] / _BLOCK)
            for block in np.unique(which):
                squares = error[which == block] ** 2
                if np.isfinite(squares).any():
                    blocks.append((float(np.nansum(squares)), int(np.isfinite(squares).sum())))
        if not blocks:
            return None
        table = np.array(blocks)
        drawn = np.random.default_rng(0).integers(0, len(blocks), (_RESAMPLES, len(blocks)))
        resampled = np.sqrt(table[drawn, 0].sum(axis=1) / table[drawn, 1].sum(axis=1))
        low, high = np.quantile(resampled, [0.025, 0.975])
        return float(np.sqrt(table[:, 0].sum() / table[:, 1].sum())), float(low), float(high)

    def by_channel(self, predicted: Predicted) -> list[dict[str, float]]:
        """RMSE in SI by run and column name."""
        result = []
        for data, readings in zip(self.problem.data, predicted.readings, strict=True):
            error = data.readings - readings
            result.append(
                {
                    self.problem.names[v]: float(np.sqrt(np.nanmean(error[:, i] ** 2)))
                    for i, v in enumerate(self.problem.variables)
                    if np.isfinite(error[:, i]).any()
                }
            )
        return result

    def _adapted(self, run: int, z: Array, freed: Sequence[Freed], fit: Fit, until: float) -> Array:
        """Fit the numbers that belong to a held-out run alone to the first part of that run."""
        own = [
            f
            for f in freed
            if f.runs == (run,) and (f.variable, f.group) not in {(g.variable, g.group) for g in fit.freed}
        ]
        data = self.problem.data[run]
        rows = data.time <= until
        for _ in range(4 if own else 0):
            _, by_slot = self.problem.predict(run, z)
            residual = ((data.readings - self.problem.finest(run, z)) / self.scales[run])[rows]
            columns = by_number(by_slot[rows], own, run, ()) / self.scales[run][None, :, None]
            good = np.isfinite(residual)
            step = np.linalg.lstsq(columns[good], residual[good], rcond=None)[0]
            for f, change in zip(own, step, strict=True):
                slots = list(f.slots)
                z[slots] = np.clip(z[slots] + change, f.lower, f.upper)
        return z


def _scales(noise: Sequence[NoiseModel], problem: Problem, run: int) -> list[float]:
    """Noise of each channel of a run in SI, by which errors of different kinds are added.

    The stated figure where it was larger than the scatter, the estimate otherwise.
    """
    return [
        problem.experiment.noise[v] if n.lasting else n.sigma
        for n, v in zip(problem.noise_in(run, noise), problem.variables, strict=True)
    ]

"""Lines through readings of the growth, and what they predict of readings that were held out.

    min  mean (y - b - c . T)^2 + r |P (c - c_0)|^2,    c >= 0

No temperature makes a link shorter: no coefficient is below 0. The ridge r draws them to what physics says:
with a plant to its own coefficients c_0, without one to equal shares of the thermometers on the link (then P
leaves out their common size). It is the r that predicts best what was held out: blocks of the log, and what
came after its beginning. How far such predictions are off, near what was learnt and far from it, is what the
law says of its own error.
Non-negative least squares: C. L. Lawson and R. J. Hanson, *Solving Least Squares Problems*, Prentice-Hall
1974, chapter 23.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, optimize

from warmlink.controllers.design.structure import nearest_shares
from warmlink.controllers.design.training import TrainingRun
from warmlink.controllers.learning.logs import Examples

Array = NDArray[np.float64]

RIDGES = tuple(10.0**k for k in np.arange(-3.0, 1.6, 0.5))
"""K2, from which the ridge is chosen."""

FORWARD = (0.5,)
"""Shares of the readings from which the rest is foretold."""

MODEL_RIDGE = 0.01
"""K2; the noise of thermometers, which a run of a model does not have."""

APART = 0.25
"""K; where thermometers went less far apart in the log, a log says less of them than physics does."""

_DOUBTS = (0.0, *10.0 ** np.arange(-4.0, 2.1, 0.25))
"""Candidates for the variance of the coefficients, by that of the predictions."""


@dataclass(frozen=True)
class GrowthLine:
    """Growth as intercept + coefficients . (T - mean).

    `inverse` is that of the covariance of those temperatures that count, in 1/K2, 0 for the others.
    """

    mean: Array
    intercept: float
    coefficients: Array
    inverse: Array

    def at(self, temperature: Array) -> Array:
        """Growth in m at temperatures in K, shape (m, k)."""
        return self.intercept + (temperature - self.mean) @ self.coefficients

    def lever(self, temperature: Array) -> Array:
        """Squared distance from what was learnt, in what was learnt, shape (m,)."""
        rise = temperature - self.mean
        return np.einsum("mi,ij,mj->m", rise, self.inverse, rise)


def line_through(temperature: Array, growth: Array, ridge: float, prior: Array, certain: bool) -> GrowthLine:
    """The line that fits best: temperatures in K, shape (m, k), growth in m, shape (m,), ridge in K2.

    `prior` are coefficients in m/K, of which the size counts only if it is `certain`.
    """
    mean, level = temperature.mean(axis=0), float(growth.mean())
    rise, size = temperature - mean, prior.size
    pull = np.eye(size)
    if not certain and prior.any():
        pull -= np.outer(prior, prior) / (prior @ prior)
    matrix = rise.T @ rise / growth.size + ridge * pull + 1e-9 * np.eye(size)
    right = rise.T @ (growth - level) / growth.size
    right = right + (ridge * prior if certain else 0.0)
    root = linalg.cholesky(matrix, lower=True)
    scale = 1e-6  # in um, since nnls has a tolerance of its own
    found = scale * optimize.nnls(root.T, linalg.solve_triangular(root, right / scale, lower=True))[0]
    counts, inverse = np.flatnonzero(found > 0), np.zeros((size, size))
    known = (rise[:, counts].T @ rise[:, counts]) / growth.size + APART**2 * np.eye(counts.size)
    inverse[np.ix_(counts, counts)] = np.linalg.inv(known)
    return GrowthLine(mean, level, found, inverse)


@dataclass(frozen=True)
class Held:
    """Predictions of what was held out: errors in m, and how far from what was learnt, shapes (m,)."""

    error: Array
    lever: Array
    blocks: int

    @property
    def rms(self) -> float:
        """Rms of all errors in m, those of later readings foretold too."""
        return float(np.sqrt(np.mean(self.error**2)))


class Learner:
    """Fits lines on some of the thermometers, with what physics says of them.

    Parameters
    ----------
    used : places of the thermometers in `SENSED`
    model : a run of a plant's model, from which coefficients are expected; None if there is none
    """

    def __init__(self, used: Sequence[int], model: TrainingRun | None = None) -> None:
        self.used, self.certain = list(used), model is not None
        self.prior = nearest_shares(self.used)
        if model is not None:
            temperature = model.temperature[:, self.used]
            line = line_through(temperature, model.elongation, MODEL_RIDGE, self.prior, certain=False)
            self.prior = line.coefficients

    def line(self, rows: Examples, ridge: float) -> GrowthLine:
        """The line through some readings."""
        return line_through(rows.temperature[:, self.used], rows.growth, ridge, self.prior, self.certain)

    def held_out(self, rows: Examples, ridge: float) -> Held:
        """Errors of each block by the others, then of what follows the beginnings of the readings."""
        blocks = np.unique(rows.block)
        splits = [(rows.block != each, rows.block == each) for each in blocks]
        order = np.arange(rows.growth.size) / rows.growth.size
        splits += [(order < share, order >= share) for share in FORWARD]
        errors, levers = [], []
        for known, unknown in splits:
            if np.count_nonzero(known) < len(self.used) + 2:
                continue
            line, rest = self.line(rows.part(known), ridge), rows.part(unknown)
            temperature = rest.temperature[:, self.used]
            errors.append(rest.growth - line.at(temperature))
            levers.append(line.lever(temperature))
        return Held(np.concatenate(errors), np.concatenate(levers), blocks.size)

    def best(self, rows: Examples) -> tuple[float, Held]:
        """The ridge in K2 that predicts best what was held out, and those predictions."""
        tried = [(ridge, self.held_out(rows, ridge)) for ridge in RIDGES]
        return min(tried, key=lambda each: each[1].rms)


def doubt(held: Held) -> tuple[float, float]:
    """Standard deviation in m of predictions near what was learnt, and variance in m2 for each lever.

    The most likely ones if the errors held out are normal. The coefficients are known no better than from one
    reading for each block: what is left within a block is of one cause.
    """
    best = (np.inf, 0.0, 0.0)
    for share in _DOUBTS:
        weight = 1.0 + share * held.lever
        variance = float(np.mean(held.error**2 / weight))
        loss = float(np.mean(np.log(variance * weight)))
        best = min(best, (loss, variance, share * variance))
    return float(np.sqrt(best[1])), max(best[2], best[1] / held.blocks)

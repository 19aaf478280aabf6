"""What the leanings of all hypotheses together say of each: a score test that knows how they scatter.

Were the model right, innovations would be white, and the leanings of hypotheses would scatter as their
products with one another say. A model of other structure leaves innovations that lean some ways again and
again, as whenever the work changes. How leanings really scatter, stretch by stretch of the sound part, is set
against what they would be by each hypothesis: the combination that tells it best gives little weight to where
the model errs anyway (P. J. Huber, "The behavior of maximum likelihood estimates under nonstandard
conditions", Proceedings of the Fifth Berkeley Symposium 1, 1967).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array

_STRETCH = 60
"""Ticks of a stretch over which leanings are summed."""

_STRETCHES = 36.0
"""Stretches of white innovations that are believed in before any is seen."""

_FLOOR = 1e-3
"""Share of the usual scatter that each leaning has by itself, as some are always the same as others."""

_SMALLEST = 1e-12


def leanings(rows: Array, combined: Array) -> tuple[Array, Array]:
    """How far a tick's innovations lean each way, and the square that this has if they are white.

    Parameters
    ----------
    rows : whitened innovations, and behind them their whitened directions, shape (readings, 1 + hypotheses)
    combined : as `combination` gives them, shape (hypotheses, things)

    Returns
    -------
    tuple
        Two of shape (things,).
    """
    seen = rows[:, 1:] @ combined
    return seen.T @ rows[:, 0], np.sum(seen**2, axis=0)


@dataclass(frozen=True)
class Scatter:
    """How leanings scatter over sound ticks.

    Attributes
    ----------
    white : in a tick, if innovations are white, on average, shape (hypotheses, hypotheses)
    found : in a tick, as stretches of the sound part have it, of the same shape
    """

    white: Array
    found: Array

    @property
    def scale(self) -> Array:
        """What makes leanings of one size, shape (hypotheses,)."""
        return np.asarray(1 / np.sqrt(np.maximum(np.diag(self.white), _SMALLEST)))

    @property
    def excess(self) -> Array:
        """What a tick adds to the scatter beyond white innovations, shape (hypotheses, hypotheses)."""
        both = np.outer(self.scale, self.scale)
        sizes, ways = np.linalg.eigh(both * (self.found - self.white))
        return np.asarray((ways * np.maximum(sizes, 0.0)) @ ways.T / both)

    def combined(self, watched: NDArray[np.bool_]) -> Array:
        """Leanings as they tell best each hypothesis that is watched, shape (hypotheses, things)."""
        found = told_by(self.found, self.white[:, watched], self.scale)
        sizes = np.einsum("ij,ik,kj->j", found, self.white, found)
        return np.asarray(found / np.sqrt(np.maximum(sizes, _SMALLEST)))


def told_by(scatter: Array, means: Array, scale: Array) -> Array:
    """Combinations of what scatters that tell means best, shape (hypotheses, means)."""
    both = np.outer(scale, scale)
    sound = both * scatter
    sound += _FLOOR * np.trace(sound) / max(np.count_nonzero(np.diag(sound)), 1) * np.eye(scale.size)
    return np.asarray(scale[:, None] * np.linalg.solve(sound, scale[:, None] * means))


def scatter_of(rows: Sequence[Array]) -> Scatter:
    """How leanings scatter over sound ticks, whose rows are as `leanings` takes them."""
    white = sum(each[:, 1:].T @ each[:, 1:] for each in rows) / len(rows)
    scores = np.array([each[:, 1:].T @ each[:, 0] for each in rows])
    count = len(rows) // _STRETCH
    sums = scores[: count * _STRETCH].reshape(count, _STRETCH, -1).sum(axis=1)
    found = (_STRETCHES * white + sums.T @ sums / _STRETCH) / (_STRETCHES + count)
    return Scatter(np.asarray(white), np.asarray(found))

"""Regularised least squares, which every plain fit is made of."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.ladder.signals import Signals

FEWEST = 12
"""Readings to which a form is fitted, at least."""

Form = Callable[[Sequence[Signals]], list[Array]]
"""Fits the fitted rows of runs, and says what all of their rows are; NaN where it cannot."""


def solved(x: Array, y: Array, share: float) -> tuple[Array, Callable[[Array], Array]]:
    """Ridge weights of columns of unit variance and a constant, and the function that scales columns so.

    Parameters
    ----------
    x : columns, shape (rows, columns)
    y : what they explain, shape (rows, channels)
    share : of the columns' own power that is added; the constant is not held back
    """
    mean, spread = x.mean(axis=0), x.std(axis=0)
    spread = np.where(spread > 1e-12 * np.maximum(np.abs(mean), 1e-300), spread, np.inf)

    def scale(table: Array) -> Array:
        return np.column_stack([(table - mean) / spread, np.ones(len(table))])

    table = scale(x)
    power = share * len(x) * np.append(np.ones(x.shape[1]), 0.0)
    gram = table.T @ table + np.diag(power)
    return np.asarray(np.linalg.lstsq(gram, table.T @ y, rcond=1e-12)[0], dtype=np.float64), scale

"""Regularised least squares, which every plain fit is made of."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.ladder.signals import Feature, Signals

FEWEST = 12
"""Readings to which a form is fitted, at least."""


@dataclass(frozen=True, eq=False)
class Linear:
    """A plain fit of one channel in SI, by the names of what it goes by.

    x[k+1] = sum over i of ahead_i x[k-i] + driven f + constant, in steps of `step` s; what is said of the
    channel is the state that stands at `place`, if there are any, plus direct f + offset.

    Attributes
    ----------
    step : s; of no effect without states
    ahead : weights of the states of so many steps before, shape (order, n, n)
    driven : of each feature's mean over the step, shape (n,)
    constant : added in each step, shape (n,)
    channels : numbers of the channels that the states are, shape (n,)
    place : number among the states of the channel that is meant
    direct : weight of each feature now
    offset : added to what is said
    above : which states are rises above the surroundings, shape (n,)
    """

    step: float = 1.0
    ahead: Array = field(default_factory=lambda: np.zeros((0, 0, 0)))
    driven: Mapping[Feature, Array] = field(default_factory=dict)
    constant: Array = field(default_factory=lambda: np.zeros(0))
    channels: tuple[int, ...] = ()
    place: int = 0
    direct: Mapping[Feature, float] = field(default_factory=dict)
    offset: float = 0.0
    above: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))

    @property
    def features(self) -> tuple[Feature, ...]:
        """What it goes by."""
        return tuple(dict.fromkeys((*self.driven, *self.direct)))

    @property
    def is_complete(self) -> bool:
        """Whether it goes by signals alone, and not by whether there is one."""
        return all(all(feature) for feature in self.features)


class Fitted(NamedTuple):
    """What a form says of every row by run, NaN where it cannot, and how, by number of the channel."""

    readings: list[Array]
    linear: Mapping[int, Linear]


Form = Callable[[Sequence[Signals]], Fitted]
"""Fits the fitted rows of runs, and says what all of their rows are."""


def regressed(x: Array, y: Array, share: float) -> tuple[Array, Array]:
    """Weights of columns and a constant by ridge: y is about x @ weights + constant.

    Parameters
    ----------
    x : columns, shape (rows, columns)
    y : what they explain, shape (rows, channels)
    share : of the columns' own power that is added, for columns of unit variance; the constant is free

    Returns
    -------
    tuple
        shapes (columns, channels) and (channels,)
    """
    mean, spread = x.mean(axis=0), x.std(axis=0)
    spread = np.where(spread > 1e-12 * np.maximum(np.abs(mean), 1e-300), spread, np.inf)
    table = np.column_stack([(x - mean) / spread, np.ones(len(x))])
    power = share * len(x) * np.append(np.ones(x.shape[1]), 0.0)
    gram = table.T @ table + np.diag(power)
    scaled = np.asarray(np.linalg.lstsq(gram, table.T @ y, rcond=1e-12)[0], dtype=np.float64)
    weights = scaled[:-1] / spread[:, None]
    return weights, scaled[-1] - mean @ weights

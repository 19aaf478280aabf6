"""Numbers of a term's shape: thresholds, memories and switches, and the values of them that are tried."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from warmlink.orchestration.arrays import Array


@dataclass(frozen=True)
class ShapeNumber:
    """A number of a form's shape, its unit, and the values of it that are tried.

    `of` is the signal whose levels give the values of a threshold; without it they are `values` in SI. What
    is `fitted` is fitted in the whole simulation; a switch is known to lie between two `levels` of the signal
    and no better.
    """

    name: str
    unit: str
    of: str = ""
    values: tuple[float, ...] = ()
    fitted: bool = True
    levels: tuple[float, ...] = ()

    def between(self, value: float) -> tuple[float, float]:
        """Levels of the fitted rows next to a value of a switch."""
        below = [each for each in self.levels if each < value]
        above = [each for each in self.levels if each >= value]
        return max(below, default=value), min(above, default=value)

    def bounds(self, value: float) -> tuple[float, float]:
        """Bounds between which it is fitted, from a value that was tried."""
        if self.unit == "K" and value > _ABSOLUTE:
            return 200.0, 420.0
        return 0.1 * value if self.unit == "s" else 0.0, 4 * value

    def seen(self, signals: Mapping[str, Array]) -> ShapeNumber:
        """The same with the levels that the signal of a switch has."""
        if self.fitted or not self.of:
            return self
        return replace(self, levels=tuple(_levels(signals[self.of])))

    def finer(self, value: float, signals: Mapping[str, Array]) -> ShapeNumber:
        """The same with more of the levels that the signal has near a value of a switch."""
        signal = signals[self.of]
        below = [each for each in self.levels if each < value][-_BESIDE:]
        above = [each for each in self.levels if each >= value][:_BESIDE]
        near = signal[(signal >= min((*below, value))) & (signal <= max((*above, value)))]
        return replace(self, levels=tuple(_levels(near)))

    def tried(self, signals: Mapping[str, Array]) -> tuple[float, ...]:
        """Values to try, by the signals of the runs."""
        if not self.of:
            return self.values
        signal = signals[self.of]
        if self.fitted:
            low, high = float(np.nanmin(signal)), float(np.nanmax(signal))
            if self.unit != "K":
                low = min(low, 0.0)
            return tuple((low + _SHARES * (high - low)).tolist())
        return _middles(_levels(signal))

    @property
    def middles(self) -> tuple[float, ...]:
        """Values of a switch between its levels."""
        return _middles(self.levels)


def _middles(levels: Sequence[float]) -> tuple[float, ...]:
    return tuple((low + high) / 2 for low, high in pairwise(levels))


def _levels(signal: Array) -> list[float]:
    """Levels of a signal, or quantiles where there are many."""
    held = signal[np.isfinite(signal)]
    levels = np.unique(np.round(held, 6))
    if levels.size > _MOST_LEVELS:
        levels = np.unique(np.quantile(held, np.linspace(0.0, 1.0, _MOST_LEVELS)))
    return [float(each) for each in levels]


_SHARES = np.linspace(0.08, 0.88, 9)
"""Where between the least and the largest value of a signal a threshold is tried."""

_ABSOLUTE = 100.0
"""K from which a temperature is no difference."""

_MOST_LEVELS = 16
"""Levels of a signal between which a switch is tried, at most."""

_BESIDE = 2
"""Levels on either side of a switch between which finer ones are tried."""

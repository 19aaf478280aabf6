"""The rungs of the ladder: models and plain fits by their errors in held-out rows, and which is best."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.ladder.baselines import Question
from warmlink.orchestration.diagnosis.ladder.least_squares import Linear
from warmlink.orchestration.diagnosis.ladder.signals import Signals

_BLOCKS = 8
"""Blocks in time of a run's held-out rows; errors in different ones count as independent."""

_FEWEST = 10
"""Held-out rows of a run, at least."""

AS_GOOD = 1.05
"""Ratio of an error to another up to which nothing is said of the difference."""


@dataclass(frozen=True)
class Rung:
    """One way to predict: readings by run in SI, shape (rows, channels) each, NaN if it has none.

    `numbers` are those that were fitted for it; `is_model` says that it can be delivered as a model, `linear`
    how a plain fit tells each channel, by its number.
    """

    name: str
    question: Question
    readings: tuple[Array, ...]
    numbers: int = 0
    is_model: bool = False
    linear: Mapping[int, Linear] = field(default_factory=dict)


@dataclass(frozen=True)
class Ladder:
    """Rungs judged on held-out rows.

    Attributes
    ----------
    runs : with the readings that are predicted
    channels : column name of each channel
    rungs : the uncorrected model first
    accuracy : error in SI by channel number, below which it does not matter
    growth : number of the channel that is the growth, if it was measured
    """

    runs: tuple[Signals, ...]
    channels: tuple[str, ...]
    rungs: tuple[Rung, ...]
    accuracy: Mapping[int, float] = field(default_factory=dict)
    growth: int | None = None

    def named(self, name: str) -> Rung:
        """The rung of a name."""
        return next(each for each in self.rungs if each.name == name)

    def with_model(self, rung: Rung) -> Ladder:
        """The same with one more model behind the others."""
        count = sum(each.is_model for each in self.rungs)
        return replace(self, rungs=(*self.rungs[:count], rung, *self.rungs[count:]))

    def plain(self, question: Question) -> list[Rung]:
        """The plain fits that answer a question."""
        return [each for each in self.rungs if not each.is_model and each.question == question]

    @cached_property
    def _blocks(self) -> tuple[tuple[int, Array], ...]:
        """Run and row numbers of each block of held-out rows."""
        blocks = []
        for i, run in enumerate(self.runs):
            rows = np.flatnonzero(~run.fitted)
            if rows.size >= _FEWEST:
                at = run.time[rows]
                place = np.floor(_BLOCKS * (at - at[0]) / (at[-1] - at[0]) * (1 - 1e-9))
                blocks += [(i, rows[place == k]) for k in range(_BLOCKS) if (place == k).any()]
        return tuple(blocks)

    @cached_property
    def _counts(self) -> Array:
        """Readings by block and channel."""
        read = [np.isfinite(self.runs[i].readings[rows]).sum(axis=0) for i, rows in self._blocks]
        return np.array(read, dtype=float).reshape(-1, len(self.channels))

    @property
    def judges_whole_runs(self) -> bool:
        """Whether all held-out rows are those of runs of which nothing was fitted."""
        return all(not run.fitted.any() for run in self.runs if not run.fitted.all())

    @property
    def is_judged(self) -> bool:
        """Whether there are held-out readings."""
        return bool(self._counts.sum() > 0)

    def _squares(self, rung: Rung) -> Array:
        """Sum of the squared errors by block and channel; infinite where a reading is not predicted."""
        table = []
        for i, rows in self._blocks:
            measured, said = self.runs[i].readings[rows], rung.readings[i][rows]
            square = np.where(np.isfinite(said), (measured - said) ** 2, np.inf)
            table.append(np.where(np.isfinite(measured), square, 0.0).sum(axis=0))
        return np.array(table).reshape(-1, len(self.channels))

    def rms(self, rung: Rung) -> dict[str, float]:
        """Root mean square error in SI on held-out rows by column name, of the channels that it predicts."""
        count = self._counts.sum(axis=0)
        mean = np.sqrt(self._squares(rung).sum(axis=0) / np.maximum(count, 1))
        return {
            name: float(error)
            for name, error, read in zip(self.channels, mean, count, strict=True)
            if read and np.isfinite(error)
        }

    @cached_property
    def _usual(self) -> Array:
        """Squared error that is usual for a channel: the geometric mean of the models', shape (channels,).

        So that no model is the measure: the uncorrected one may be right in a channel by luck.
        """
        count = np.maximum(self._counts.sum(axis=0), 1)
        squares = [self._squares(rung).sum(axis=0) / count for rung in self.rungs if rung.is_model]
        logarithms = np.log(np.maximum(np.maximum(squares, self._matters), 1e-30))
        return np.asarray(np.exp(np.where(np.isfinite(logarithms), logarithms, 0.0).mean(axis=0)))

    @property
    def _matters(self) -> Array:
        """Squared error below which nothing matters, shape (channels,)."""
        return np.array([self.accuracy.get(i, 0.0) ** 2 for i in range(len(self.channels))])

    def _shares(self, rung: Rung) -> Array:
        """By block, squared errors as shares of what is usual, as a mean over the channels."""
        count = self._counts.sum(axis=0)
        read = count > 0
        squares = np.maximum(self._squares(rung), self._matters * self._counts)
        return np.asarray(squares[:, read] / (self._usual * count)[read]).mean(axis=1)

    def score(self, rung: Rung) -> float:
        """Mean square error as a share of what is usual for each channel, mean over the channels."""
        return float(self._shares(rung).sum())

    def is_worse_in_growth(self, rung: Rung) -> bool:
        """Whether a rung foretells the growth worse than the uncorrected model, so that it matters."""
        if self.growth is None:
            return False
        least = self.accuracy.get(self.growth, 0.0)
        name = self.channels[self.growth]
        ours, first = (self.rms(each).get(name, np.inf) for each in (rung, self.rungs[0]))
        return max(ours, least) > AS_GOOD * max(first, least)

    def better_by(self, one: Rung, other: Rung) -> tuple[float, float]:
        """By how much of the score a rung is better than another, and the standard error of that."""
        return _gained(self._shares(other) - self._shares(one))

    def best_in(self, channel: int, rungs: Sequence[Rung], than: Rung) -> Rung | None:
        """The rung that tells a channel best, if that is clearly better than another does; else None.

        Clearly: by more than a standard error, and so that the difference would be told and matters.
        """
        matters, name = self.accuracy.get(channel, 0.0), self.channels[channel]
        best = min(rungs, key=lambda each: self.rms(each).get(name, np.inf), default=than)
        ours, theirs = (max(self.rms(each).get(name, np.inf), matters) for each in (best, than))
        if not theirs > AS_GOOD * ours:
            return None
        gained, spread = _gained((self._squares(than) - self._squares(best))[:, channel])
        return best if gained > spread else None

    def simplest_of_the_best(self, rungs: Sequence[Rung]) -> Rung:
        """The first of some rungs than which none is better by more than one standard error."""
        best = min(rungs, key=self.score)
        for rung in rungs:
            gained, spread = self.better_by(best, rung)
            if gained <= spread:
                return rung
        return best


def _gained(by_block: Array) -> tuple[float, float]:
    """Sum of what blocks gain, and the standard error of that."""
    count = by_block.size
    spread = float(np.sqrt(count) * by_block.std(ddof=1)) if count > 1 else 0.0
    return float(by_block.sum()), spread

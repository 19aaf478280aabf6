"""Predictions of a fit for similar sets of causes, with some added or removed, without a simulation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.algebra import correlation_of, inverse_of, root_of
from warmlink.orchestration.diagnosis.fit.candidates import FreeNumber, Item
from warmlink.orchestration.diagnosis.fit.fitting import Fit, of_numbers

_COLLINEAR = 1 - 1e-6
_DRAWS = 6000

MADE_UP_FOR = 1e-4
"""Share of what a cause changes that may be left where others make up for it."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """A set of causes not fitted yet, the chi-square expected of it, and what computes its start in SI."""

    items: tuple[Item, ...]
    chi2: float
    start: Callable[[], dict[FreeNumber, float]]

    @cached_property
    def key(self) -> frozenset[str]:
        """Titles of the causes."""
        return frozenset(item.title for item in self.items)


class Neighbours:
    """Linearised outcome of adding causes to a fit from which some were taken back.

    Parameters
    ----------
    fit : the fit whose linearisation serves
    candidates : every cause that may be added
    removed : causes of the fit that are taken back to their neutral values
    """

    def __init__(self, fit: Fit, candidates: Sequence[Item], removed: Sequence[Item]) -> None:
        taken = {item.name for item in fit.items} - {item.name for item in removed}
        self.candidates = [i for i in candidates if i.name not in taken and i.title not in fit.key]
        gone = {f for item in removed for f in item.freed}
        self.base = [f for f in fit.freed if f not in gone]
        self.added = [f for item in self.candidates for f in item.freed]
        self.values = fit.values
        back = [f for f in fit.freed if f in gone]
        point = fit.point.moved(back, np.array([f.start - self.values[f] for f in back]), fit.freed)
        gram, gradient = of_numbers([*self.base, *self.added], fit.freed, point)
        n = len(self.base)
        self._inverse, self._across = inverse_of(gram[:n, :n], 1e-10), gram[n:, :n]
        self._inner_gradient = gradient[:n]
        self.chi2 = point.chi2 - float(gradient[:n] @ self._inverse @ gradient[:n])
        self.gram = gram[n:, n:] - self._across @ self._inverse @ self._across.T
        self.gradient = gradient[n:] - self._across @ self._inverse @ gradient[:n]
        self.left = np.diag(self.gram) / np.maximum(np.diag(gram)[n:], 1e-300)
        # A column that the calibration explains all but entirely says nothing.
        self.alive = self.left > 1e-7
        starts = np.cumsum([0, *(len(item.freed) for item in self.candidates)])
        self.spans = [slice(a, b) for a, b in pairwise(starts)]
        self._all = np.arange(starts[-1])
        self._lower = np.array([f.lower - f.start for f in self.added])
        self._upper = np.array([f.upper - f.start for f in self.added])

    def usable(self) -> list[int]:
        """Indices of candidates that affect the data."""
        return [i for i, span in enumerate(self.spans) if self.alive[span].all()]

    def outcomes(self, chosen: Sequence[Sequence[int]]) -> list[tuple[float, Array]]:
        """Gain in chi-square of adding each set of candidates, and their values' changes.

        The gain of a set that is not feasible is minus infinity.
        """
        columns = [self.columns_of(each) for each in chosen]
        found: dict[int, tuple[float, Array]] = {}
        for size in {each.size for each in columns}:
            places = [k for k, each in enumerate(columns) if each.size == size]
            gains, changes = self._outcomes(np.array([columns[k] for k in places], dtype=int))
            found |= dict(zip(places, zip(gains.tolist(), changes, strict=True), strict=True))
        return [found[k] for k in range(len(columns))]

    def columns_of(self, chosen: Sequence[int]) -> NDArray[np.int64]:
        """Columns of candidates, one after another."""
        return np.concatenate([self._all[self.spans[i]] for i in chosen] or [self._all[:0]])

    def _outcomes(self, index: NDArray[np.int64]) -> tuple[Array, Array]:
        """As `outcomes`, of sets of as many columns each, shape (sets, columns)."""
        gram, gradient = self.gram[index[:, :, None], index[:, None, :]], self.gradient[index]
        scale = np.sqrt(np.diagonal(gram, axis1=1, axis2=2))
        correlation = gram / (scale[:, :, None] * scale[:, None, :])
        feasible = np.linalg.eigvalsh(correlation).min(axis=1, initial=1.0) >= 1 - _COLLINEAR
        correlation[~feasible] = np.eye(index.shape[1])
        change = np.linalg.solve(correlation, (gradient / scale)[:, :, None])[:, :, 0] / scale
        lower, upper = self._lower[index], self._upper[index]
        room = upper - lower
        past = ((change < lower - 0.02 * room) | (change > upper + 2.0 * room)).any(axis=1)
        falling, rising = (lower == 0) & (change < 0), (upper == 0) & (change > 0)
        # Past a bound that is not the neutral value there may still be something when fitted in full.
        feasible &= ~(falling | (rising & past[:, None])).any(axis=1)
        change = np.where(past[:, None], np.clip(change, lower, upper), change)
        gain = 2 * np.einsum("si,si->s", gradient, change) - np.einsum("si,sij,sj->s", change, gram, change)
        return np.where(feasible, gain, -np.inf), change

    def alone(self) -> Iterable[tuple[Item, int, dict[FreeNumber, float]]]:
        """Each candidate of one number, its column, and by how much the fit's numbers move for 1 of it."""
        for item, span in zip(self.candidates, self.spans, strict=True):
            if len(item.freed) == 1:
                follows = -self._inverse @ self._across[span.start]
                yield item, span.start, dict(zip(self.base, follows.tolist(), strict=True))

    def unnoticed(self) -> Iterable[tuple[Item, dict[FreeNumber, float]]]:
        """Each candidate of one number, and by how much all numbers are off, in SI, if it is by one sigma."""
        for item, k, follows in self.alone():
            if self.alive[k]:
                off = min(1 / np.sqrt(self.gram[k, k]), self.added[k].span)
                yield item, {self.added[k]: off, **{f: rate * off for f, rate in follows.items()}}

    def singles(self) -> Iterable[tuple[int, ...]]:
        """Each candidate by itself."""
        return ((i,) for i in self.usable())

    def pairs(self) -> Iterable[tuple[int, ...]]:
        """The pairs that promise most."""
        usable = [i for i in self.usable() if self.spans[i].stop - self.spans[i].start == 1]
        columns = np.array([self.spans[i].start for i in usable], dtype=int)
        a, b = np.triu_indices(columns.size, 1)
        i, j = columns[a], columns[b]
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(np.diag(self.gram))  # in units of it no product overflows
            alike = self.gram[i, j] / root[i] / root[j]
            a_alone, b_alone = self.gradient[i] / root[i], self.gradient[j] / root[j]
            left = 1 - alike**2
            found = (a_alone**2 - 2 * alike * a_alone * b_alone + b_alone**2) / left
        gain = np.where(left > 1 - _COLLINEAR, found, 0.0)
        order = np.argsort(gain)[::-1][:30]
        return [(usable[a[k]], usable[b[k]]) for k in order]

    def proposals(self, kept: tuple[Item, ...], chosen: Sequence[Sequence[int]]) -> Iterable[Proposal]:
        """Sets of the kept causes and each set of candidates, with what is expected of them."""
        for each, (gain, change) in zip(chosen, self.outcomes(chosen), strict=True):
            items = (*kept, *(self.candidates[i] for i in each))
            yield Proposal(items, self.chi2 - gain, partial(self._start, each, change))

    def _start(self, chosen: Sequence[int], change: Array) -> dict[FreeNumber, float]:
        """Values in SI where the candidates' values are changed, and the others follow."""
        index = self.columns_of(chosen)
        follows = self._inverse @ (self._inner_gradient - self._across[index].T @ change)
        start = {f: self.values[f] + delta for f, delta in zip(self.base, follows, strict=True)}
        start |= {self.added[k]: self.added[k].start + delta for k, delta in zip(index, change, strict=True)}
        return {f: float(np.clip(value, f.lower, f.upper)) for f, value in start.items()}


def prior_shares(items: Sequence[Item]) -> dict[str, float]:
    """Weight of each candidate by the name of its cause, which all candidates of one cause share equally.

    So a cause that may be tried on many channels or labels is not found more easily by chance.
    """
    counts = Counter(item.cause.name for item in items)
    return {name: 1 / count for name, count in counts.items()}


def family_wise_level(null: Neighbours, false_alarms: float) -> float:
    """Probability level of one cause at which `false_alarms` of runs with nothing wrong would stop.

    Drawn from the joint normal distribution of all candidates' gradients, bounds included.
    """
    from scipy.special import chdtrc, erfc

    usable = null.usable()
    if not usable:
        return false_alarms
    # A candidate that does not affect the data has a column of rounding, which no correlation may hold.
    sizes = [len(null.candidates[i].freed) for i in usable]
    columns = null.columns_of(usable)
    correlation, _ = correlation_of(null.gram[np.ix_(columns, columns)])
    draws = root_of(correlation) @ np.random.default_rng(0).standard_normal((columns.size, _DRAWS))
    share = prior_shares(null.candidates)
    # Among candidates of equal weight and number of values the largest gain is the least probable.
    largest: dict[tuple[int, float], Array] = {}
    for i, first, size in zip(usable, np.cumsum([0, *sizes[:-1]]), sizes, strict=True):
        span = slice(first, first + size)
        z = draws[span]
        if size == 1:
            one_sided = null._lower[columns[first]] == 0
            gain = np.where(one_sided & (z[0] < 0), 0.0, z[0] ** 2)
        else:
            gain = np.sum(z * np.linalg.solve(correlation[span, span], z), axis=0)
        kind = size, share[null.candidates[i].cause.name]
        largest[kind] = np.maximum(largest[kind], gain) if kind in largest else gain
    # Of one number the chance is that of a normal one to be as large, which is found ten times as fast.
    probable = [
        (erfc(np.sqrt(gain / 2)) if freed == 1 else chdtrc(freed, gain)) / weight
        for (freed, weight), gain in largest.items()
    ]
    return float(np.quantile(np.minimum(np.min(probable, axis=0), 1.0), false_alarms))

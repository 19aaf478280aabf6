"""Terms fitted to what the readings answer to heat, so that only what comes near the best is simulated.

Such a fit says nearly what one in the whole simulation says, in a thousandth of the time. The strengths of
terms are solved for, the numbers of their shapes move by Gauss-Newton steps (G. H. Golub and V. Pereyra, SIAM
Journal on Numerical Analysis 10 (1973) 413: nonlinear least squares whose variables separate).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.terms.library import Candidate
from warmlink.orchestration.diagnosis.terms.missing import Missing
from warmlink.orchestration.diagnosis.terms.shape import ShapeNumber

_MOST_STEPS, _SHORTEST = 8, 0.1
"""Gauss-Newton steps at most, and the share of a step below which it is given up."""

_TIMES_FINER = 2
"""Times that the levels between which a switch lies are made finer."""

_SMALL = 0.1
"""Decrease of chi-square that is worth no further step."""

_SAME, _AGREES = 1.0, 1e-4
"""Chi-square between what two models say below which nothing tells them apart, and the share of what one says
below which the other agrees with it."""

_BESIDE = 2e-3
"""Change of a shape's number for its derivative, as a share of its range in the data or of its value."""


@dataclass(frozen=True)
class LinearFit:
    """Candidates with the strengths in W that the linear answers give them.

    Attributes
    ----------
    missing : what the readings answer
    candidates : terms, with the numbers of their shapes
    bounds : of the numbers of shapes that are fitted, lowest and highest of each; if empty, the usual ones
        around their values
    target : whitened readings that are fitted, shape (rows,); None for what the model leaves
    """

    missing: Missing
    candidates: tuple[Candidate, ...]
    bounds: tuple[tuple[float, float], ...] = ()
    target: Array | None = None

    @property
    def _wanted(self) -> Array:
        return self.missing.residual if self.target is None else self.target

    @cached_property
    def columns(self) -> Array:
        """What the readings answer to each term of 1 W, shape (rows, terms)."""
        return self.missing.columns(self.candidates)

    @cached_property
    def strengths(self) -> Array:
        """Strength of each term in W, shape (terms,)."""
        size = np.maximum(np.linalg.norm(self.columns, axis=0), 1e-300)
        return np.linalg.lstsq(self.columns / size, self._wanted, rcond=1e-10)[0] / size

    @cached_property
    def left(self) -> Array:
        """What the terms leave of the whitened residuals, shape (rows,)."""
        return self._wanted - self.columns @ self.strengths

    @property
    def chi2(self) -> float:
        """Chi-square."""
        return float(self.left @ self.left)

    @property
    def numbers(self) -> int:
        """Numbers of its terms."""
        return sum(each.numbers for each in self.candidates)

    @property
    def switches(self) -> bool:
        """Whether one of the terms is switched by a signal."""
        return any(not shape.fitted for each in self.candidates for shape in each.form.shapes)

    @cached_property
    def _fitted(self) -> list[tuple[int, int]]:
        """Term and place of each shape's number that is fitted."""
        return [
            (i, j)
            for i, each in enumerate(self.candidates)
            for j, shape in enumerate(each.form.shapes)
            if shape.fitted
        ]

    def polished(self) -> LinearFit:
        """The same with the numbers of the shapes fitted too."""
        best = self
        for _ in range(_MOST_STEPS if self._fitted else 0):
            step, share = best._step(), 1.0
            ahead = best.moved(step)
            while ahead.chi2 >= best.chi2 and share > _SHORTEST:
                share /= 3
                ahead = best.moved(share * step)
            gained = best.chi2 - ahead.chi2
            best = ahead if gained > 0 else best
            if gained < _SMALL:
                break
        return best._switched()

    def _switched(self) -> LinearFit:
        """The same with switches between finer levels of signals that have many."""
        best = self
        switches = [
            (i, j)
            for i, each in enumerate(self.candidates)
            for j, shape in enumerate(each.form.shapes)
            if not shape.fitted
        ]
        for i, j in switches * _TIMES_FINER:
            signals, each = self.missing.followed.on_fitted_rows, best.candidates[i]
            known = each.form.shapes[j]
            shape = known.finer(each.shape[j], signals)
            if set(shape.levels) <= set(known.levels):
                continue
            tried = [best._with_switch(i, j, shape, value) for value in shape.middles]
            best = min(tried, key=lambda fit: fit.chi2)
        return best

    def _with_switch(self, i: int, j: int, shape: ShapeNumber, value: float) -> LinearFit:
        """The same with another value of a switch, which is known by the levels of its shape."""
        each, some = self.candidates[i], list(self.candidates)
        shapes = (*each.form.shapes[:j], shape, *each.form.shapes[j + 1 :])
        values = (*each.shape[:j], value, *each.shape[j + 1 :])
        some[i] = replace(each, form=replace(each.form, shapes=shapes), shape=values)
        return replace(self, candidates=tuple(some))

    def _step(self) -> Array:
        """Gauss-Newton step of the shapes' numbers, shape (numbers,)."""
        beside = np.array([_BESIDE * max(abs(self._value(at)), _BESIDE) for at in self._fitted])
        changed = [self.moved(change) for change in np.diag(beside)]
        slopes = [
            (each.columns - self.columns) @ self.strengths / size
            for each, size in zip(changed, beside, strict=True)
        ]
        table = np.column_stack([self.columns, *slopes])
        size = np.maximum(np.linalg.norm(table, axis=0), 1e-300)
        step = np.linalg.lstsq(table / size, self.left, rcond=1e-6)[0] / size
        return np.asarray(step[len(self.candidates) :])

    def _value(self, at: tuple[int, int]) -> float:
        return self.candidates[at[0]].shape[at[1]]

    def moved(self, change: Array) -> LinearFit:
        """The same with other numbers of the shapes, within their bounds."""
        shapes = [list(each.shape) for each in self.candidates]
        bounds = self.bounds or tuple(
            self.candidates[i].form.shapes[j].bounds(shapes[i][j]) for i, j in self._fitted
        )
        for (i, j), by, (low, high) in zip(self._fitted, change.tolist(), bounds, strict=True):
            shapes[i][j] = float(np.clip(shapes[i][j] + by, low, high))
        every = zip(self.candidates, shapes, strict=True)
        moved = tuple(replace(each, shape=tuple(shape)) for each, shape in every)
        return replace(self, candidates=moved, bounds=bounds)


def without_idle_numbers(fits: Sequence[LinearFit]) -> list[int]:
    """Indices of fits but for those that need a number less to say the same, as a dead zone of no width.

    Such a one contains a simpler model, for some numbers of its shapes, and is not told from it. Others that
    say the same are other explanations.
    """
    order = sorted(range(len(fits)), key=lambda i: fits[i].numbers)
    kept: list[int] = []
    for i in order:
        simpler = [fits[j] for j in kept if fits[j].numbers < fits[i].numbers]
        alike = [each for each in simpler if np.sum((fits[i].left - each.left) ** 2) < _SAME]
        if not any(_contains(fits[i], each) for each in alike):
            kept.append(i)
    return sorted(kept)


def _contains(fit: LinearFit, simpler: LinearFit) -> bool:
    """Whether a model says what a simpler one says for some numbers of its shapes."""
    said = simpler.columns @ simpler.strengths
    return replace(fit, target=said).polished().chi2 < _AGREES * float(said @ said)

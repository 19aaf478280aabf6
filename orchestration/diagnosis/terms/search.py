"""Which terms, up to three together, explain what a model leaves: chosen sparsely, fitted in the simulation.

What the readings answer to a heat tells what each candidate would gain (`missing.py`). The most promising are
fitted in the whole simulation, alone first; where none explains the run, further terms are added to the best.
A model costs its description: which terms of the library it has, and each of its numbers (J. Rissanen,
Modeling by shortest data description, Automatica 14 (1978) 465).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.fitted import UNEXPLAINED, lack_of_fit_p
from warmlink.orchestration.diagnosis.fit.search import NEAR
from warmlink.orchestration.diagnosis.fit.verdict import Assessment
from warmlink.orchestration.diagnosis.model.simulation import NotSimulatedError
from warmlink.orchestration.diagnosis.terms.library import Candidate, candidates
from warmlink.orchestration.diagnosis.terms.missing import Missing, on_fitted_rows
from warmlink.orchestration.diagnosis.terms.modelled import Chosen, Modelled, bare, fitted, fitted_again
from warmlink.orchestration.progress import Progress, unseen

MOST_TERMS = 3

_FULL = (20, 10, 6)
"""Models of one, two and three terms that are fitted in the whole simulation, at most."""

_SLACK, _SHARE = 40.0, 0.05
"""Chi-square, and share of the best one's gain, by which the linear estimate may be off."""

_GROWN_FROM = 4
"""Models to which a further term is added."""

_SETTLED = 12
"""Models of a number of terms whose grid and leaps are taken at their own values, at most."""

_SAME = 1e-9


@dataclass(frozen=True)
class FittedTerms:
    """A model with terms that was fitted, its score, and how likely noise leaves so much.

    `settled` says that grid and leaps were taken as they are at its own values.
    """

    model: Modelled
    score: float
    chance: float
    settled: bool = False

    @property
    def explains(self) -> bool:
        """Whether what it leaves may be noise, and no number would rather lie beyond its bound."""
        return self.chance >= UNEXPLAINED and not self.model.on_bound


class TermSearch:
    """Fits sets of terms; `tried` has every model that was fitted, best first."""

    def __init__(self, assessment: Assessment, missing: Missing, progress: Progress = unseen) -> None:
        self.assessment, self.missing, self._progress = assessment, missing, progress
        self.library = list(candidates(on_fitted_rows(missing), missing.places))
        columns = np.column_stack([missing.column(each) for each in self.library])
        size = np.linalg.norm(columns, axis=0)
        known = size > max(float(size.max(initial=0.0)), 1.0) * _SAME
        self.library = [each for each, good in zip(self.library, known, strict=True) if good]
        self._columns, self._size = columns[:, known] / size[known], size[known]
        self._bare = bare(assessment)
        self._kept: dict[frozenset[tuple[str, str]], FittedTerms] = {}

    @cached_property
    def forms(self) -> int:
        """Forms at places that were thought of."""
        return len({each.key for each in self.library})

    def price(self, numbers: int, terms: int) -> float:
        """Cost of a model with so many numbers and terms, in chi-square."""
        return self.of_number * numbers + 2 * float(np.log(max(self.forms, 2))) * terms

    @property
    def of_number(self) -> float:
        """Cost of a number."""
        return float(np.log(max(self._bare.fitter.count, 2)))

    @property
    def bare_score(self) -> float:
        """Score of the machine without terms."""
        return self._bare.fit.chi2

    @property
    def tried(self) -> list[FittedTerms]:
        """Every model that was fitted, best first."""
        return sorted(self._kept.values(), key=lambda each: each.score)

    def run(self) -> list[FittedTerms]:
        """Search, and give the models that explain the run, best first.

        A further term is sought as long as none explains it and the last one was worth its description.
        """
        sets: list[tuple[int, ...]] = [()]
        best = self.bare_score
        for terms in range(1, MOST_TERMS + 1):
            sets = self._fit(list(self._grown(sets)), _FULL[terms - 1])
            self._settle()
            if self.explaining or not sets or self.tried[0].score >= best:
                break
            best = self.tried[0].score
        return self.explaining

    @property
    def explaining(self) -> list[FittedTerms]:
        """Models that explain the run and are worth their description, best first."""
        return [
            each for each in self.tried if each.settled and each.explains and each.score < self.bare_score
        ]

    def _settle(self) -> None:
        """Fit the best models again, with the grid's error, and what leaps do, as they are with their terms.

        A switch leaps with its input, at some time between two rows.
        """
        least = self.tried[0].score if self.tried else 0.0
        near = [each for each in self.tried if each.score < least + 2 * NEAR and not each.settled]
        for each in near[:_SETTLED]:
            self._keep(fitted_again(each.model), settled=True)

    def _grown(self, sets: Sequence[tuple[int, ...]]) -> Iterator[tuple[float, tuple[int, ...]]]:
        """Linear estimate of the score of each set with one more candidate; the best shape of a form."""
        y = self.missing.residual
        for kept in sets:
            basis = np.linalg.qr(self._columns[:, list(kept)])[0]
            left = y - basis @ (basis.T @ y)
            free = self._columns - basis @ (basis.T @ self._columns)
            length = np.linalg.norm(free, axis=0)
            gain = np.where(length > 1e-3, (free.T @ left) ** 2 / np.maximum(length, 1e-12) ** 2, 0.0)
            chosen = {self.library[i].key for i in kept}
            best: dict[tuple[str, str], tuple[float, int]] = {}
            for i in np.argsort(-gain).tolist():
                if self.library[i].key not in chosen:
                    best.setdefault(self.library[i].key, (float(gain[i]), i))
            for each, i in best.values():
                whole = (*kept, i)
                numbers = sum(self.library[j].numbers for j in whole)
                yield float(left @ left) - each + self.price(numbers, len(whole)), whole

    def _fit(self, proposals: list[tuple[float, tuple[int, ...]]], most: int) -> list[tuple[int, ...]]:
        """Fit the most promising proposals; returns those from which to go on."""
        unlike: dict[frozenset[tuple[str, str]], tuple[float, tuple[int, ...]]] = {}
        for score, which in sorted(proposals):
            unlike.setdefault(frozenset(self.library[i].key for i in which), (score, which))
        ranked = list(unlike.values())
        if not ranked:
            return []
        slack = _SLACK + _SHARE * max(self.bare_score - ranked[0][0], 0.0)
        ranked = [each for each in ranked if each[0] < ranked[0][0] + slack][:most]
        found = []
        for k, (_, which) in enumerate(ranked):
            self._progress(f"terms: {' + '.join(self.library[i].form.about for i in which)}", k / most)
            tried = self._fitted(which)
            if tried is not None:
                found.append((tried.score, which))
        return [which for _, which in sorted(found)[:_GROWN_FROM]]

    def _fitted(self, which: tuple[int, ...]) -> FittedTerms | None:
        chosen = self._chosen(which)
        try:
            return self._keep(fitted(self.assessment, chosen))
        except NotSimulatedError:
            return None

    def _chosen(self, which: tuple[int, ...]) -> Chosen:
        """Candidates with the strengths that the linear answers give them."""
        table = self._columns[:, list(which)]
        strengths = np.linalg.lstsq(table, self.missing.residual, rcond=None)[0] / self._size[list(which)]
        some = tuple(self.library[i] for i in which)
        return Chosen(some, tuple(strengths.tolist()), tuple(map(self.missing.largest, some)))

    def _keep(self, model: Modelled, settled: bool = False) -> FittedTerms:
        score = model.fit.chi2 + self.price(model.numbers, len(model.chosen.candidates))
        tried = FittedTerms(model, score, lack_of_fit_p(model.fitter, model.fit), settled)
        self._kept[model.chosen.key] = tried
        return tried


def heat_of(model: Modelled, missing: Missing, number: int) -> list[Array]:
    """Heat in W of a term, counted from 1, at the rows of each run."""
    refitted = model.refitted()
    candidate: Candidate = refitted.candidates[number - 1]
    strength = refitted.strengths[number - 1]
    return [strength * missing.course(run, candidate) for run in range(len(missing.nodes))]

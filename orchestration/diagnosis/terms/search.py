"""Which terms, up to three together, explain what a model leaves: chosen sparsely, fitted in the simulation.

What the readings answer to a heat tells what each candidate gains (`linear.py`), alone first. Those that come
near the best are fitted in the whole simulation; where none explains the run, further terms are added to the
best. A model costs its description: which terms of the library it has, and each of its numbers (J. Rissanen,
Modeling by shortest data description, Automatica 14 (1978) 465).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from warmlink.orchestration.diagnosis.fit.fitted import UNEXPLAINED, lack_of_fit_p
from warmlink.orchestration.diagnosis.fit.search import NEAR
from warmlink.orchestration.diagnosis.fit.verdict import Assessment
from warmlink.orchestration.diagnosis.model.simulation import NotSimulatedError
from warmlink.orchestration.diagnosis.terms.library import Candidate, candidates
from warmlink.orchestration.diagnosis.terms.linear import LinearFit, without_idle_numbers
from warmlink.orchestration.diagnosis.terms.missing import Missing
from warmlink.orchestration.diagnosis.terms.modelled import Chosen, Modelled, fitted
from warmlink.orchestration.progress import Progress, unseen

MOST_TERMS = 3

_SCREENED = (30, 20, 16)
"""Models of one, two and three terms whose shapes are fitted to the linear answers, at most."""

_FULL = (12, 6, 4)
"""Models of one, two and three terms that are fitted in the whole simulation, at most."""

_SLACK, _SHARE, _SWITCHED = 6.0, 0.006, 40.0
"""Chi-square, and share of the best one's gain, by which two linear scores may be off against each other; and
that of a switch, which leaps with its input at some time between two rows."""

_FAR, _OFF = 0.3, 0.3
"""Share of its gain by which a linear score may be off by itself, as heat moves a machine from where it was
linearised, a heater to its end stop for example; and the share of what the best one is off by, by which
others may be off against it."""

_STRONGEST = 1e3
"""W from which a strength is no heat of a machine, but a shape that vanishes where the run was."""

_GROWN_FROM = 4
"""Models to which a further term is added."""

_HOPELESS = 1e-12
"""Chance level of what the best model leaves, below which those near it are not fitted."""

_AS_WELL = 2.0
"""Chi-square up to which a model fits as well as the best one."""

_SAME = 1e-9


@dataclass(frozen=True)
class FittedTerms:
    """A model with terms that was fitted, its score, and how likely noise leaves so much."""

    model: Modelled
    score: float
    chance: float

    @property
    def explains(self) -> bool:
        """Whether what it leaves may be noise, and no number would rather lie beyond its bound."""
        return self.chance >= UNEXPLAINED and not self.model.on_bound


def is_near(score: float, chi2: float, slack: float = 0.0) -> bool:
    """Whether data do not tell a model from the best one, whose score and chi-square are so much less.

    What fits as well may be the truth though it takes another number to describe.
    """
    return score < NEAR + slack or chi2 < _AS_WELL + slack


class TermSearch:
    """Fits sets of terms; `tried` has every model that was fitted, best first."""

    def __init__(self, assessment: Assessment, missing: Missing, progress: Progress = unseen) -> None:
        self.assessment, self.missing, self._progress = assessment, missing, progress
        self.library = list(candidates(missing.followed.on_fitted_rows, missing.places))
        columns = missing.columns(self.library)
        size = np.linalg.norm(columns, axis=0)
        known = size > max(float(size.max(initial=0.0)), 1.0) * _SAME
        self.library = [each for each, good in zip(self.library, known, strict=True) if good]
        self._columns = columns[:, known] / size[known]
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
        return float(np.log(max(self.missing.fitter.count, 2)))

    @property
    def bare_score(self) -> float:
        """Score of the machine without terms."""
        return float(self.missing.residual @ self.missing.residual)

    @property
    def needs_none(self) -> bool:
        """Whether what the machine without terms leaves may be noise, beside what wanders."""
        return lack_of_fit_p(self.assessment.fitter, self.assessment.null) >= UNEXPLAINED

    @property
    def tried(self) -> list[FittedTerms]:
        """Every model that was fitted, best first."""
        return sorted(self._kept.values(), key=lambda each: each.score)

    @property
    def explaining(self) -> list[FittedTerms]:
        """Models that explain the run and are worth their description, best first."""
        return [each for each in self.tried if each.explains and each.score < self.bare_score]

    def run(self, bar: float = np.inf) -> list[FittedTerms]:
        """Search, and give the models that explain the run, best first.

        A further term is sought as long as none explains it and the last one was worth its description.

        Parameters
        ----------
        bar : score above which a model matters to nobody
        """
        sets, best = [LinearFit(self.missing, ())], self.bare_score
        for terms in range(1, MOST_TERMS + 1):
            sets = self._screened(sets, _SCREENED[terms - 1])
            if not sets or self._linear_score(sets[0]) >= best:
                break
            best = self._linear_score(sets[0])
            if best < bar + _SLACK + _FAR * max(self.bare_score - best, 0.0):
                self._simulate(sets, _FULL[terms - 1], bar)
            if self.explaining:
                break
            sets = sets[:_GROWN_FROM]
        self._leave_out()
        return self.explaining

    def _leave_out(self) -> None:
        """Fit the best models that leave noise without each of their terms too.

        By the simulation, one may be idle without which the linear answers explained the run poorly.
        """
        best = [each for each in self.tried if each.chance >= UNEXPLAINED][:_GROWN_FROM]
        for chosen in [fewer for each in best for fewer in each.model.refitted().without_each()]:
            if chosen.candidates and chosen.key not in self._kept:
                with suppress(NotSimulatedError):
                    self._keep(fitted(self.assessment, chosen))

    def _linear_score(self, fit: LinearFit) -> float:
        return fit.chi2 + self.price(fit.numbers, len(fit.candidates))

    def _screened(self, sets: Sequence[LinearFit], most: int) -> list[LinearFit]:
        """The most promising models of one term more, with their shapes fitted, best first."""
        unlike: dict[frozenset[tuple[str, str]], tuple[float, tuple[Candidate, ...]]] = {}
        for score, some in sorted(self._grown(sets), key=lambda pair: pair[0]):
            unlike.setdefault(frozenset(each.key for each in some), (score, some))
        ranked = [LinearFit(self.missing, some).polished() for _, some in list(unlike.values())[:most]]
        credible = [each for each in ranked if np.abs(each.strengths).max(initial=0.0) < _STRONGEST]
        return sorted(credible, key=self._linear_score)

    def _grown(self, sets: Sequence[LinearFit]) -> Iterator[tuple[float, tuple[Candidate, ...]]]:
        """Linear estimate of the score of each set with one more candidate; the best shape of a form."""
        for kept in sets:
            basis = np.linalg.qr(kept.columns)[0]
            free = self._columns - basis @ (basis.T @ self._columns)
            length = np.linalg.norm(free, axis=0)
            gain = np.where(length > 1e-3, (free.T @ kept.left) ** 2 / np.maximum(length, 1e-12) ** 2, 0.0)
            chosen = {each.key for each in kept.candidates}
            best: dict[tuple[str, str], int] = {}
            for i in np.argsort(-gain).tolist():
                if self.library[i].key not in chosen:
                    best.setdefault(self.library[i].key, i)
            for i in best.values():
                some = (*kept.candidates, self.library[i])
                price = self.price(sum(each.numbers for each in some), len(some))
                yield kept.chi2 - float(gain[i]) + price, some

    def _simulate(self, ranked: Sequence[LinearFit], most: int, bar: float) -> None:
        """Fit the best model in the whole simulation, and what comes near it and may be below the bar.

        What that one is off by tells how far the linear answers hold; those near a best one that is far from
        explaining the run are left alone.
        """
        first = self._simulated(ranked[0], None)
        second = self._simulated(ranked[1], first) if len(ranked) > 1 and _is_hopeless(first) else first
        if _is_hopeless(first) and _is_hopeless(second):
            return
        off = 0.0 if first is None else first.score - self._linear_score(ranked[0])
        near = [each for each in self._near(ranked, _OFF * abs(off))[:most] if each is not ranked[0]]
        # Others gain as much again by the simulation, and not all alike.
        highest = bar + _SLACK + 2 * max(-off, 0.0)
        near = [each for each in near if self._linear_score(each) < highest + _SWITCHED * each.switches]
        for k, each in enumerate(near, start=1):
            self._progress(f"terms: {' + '.join(c.form.about for c in each.candidates)}", k / (len(near) + 1))
            self._simulated(each, first)

    def _simulated(self, fit: LinearFit, like: FittedTerms | None) -> FittedTerms | None:
        """A model fitted in the whole simulation, like another one; None if that cannot be simulated."""
        beside = None if like is None or fit.switches else like.model
        try:
            return self._keep(fitted(self.assessment, self._chosen(fit), beside))
        except NotSimulatedError:
            return None

    def _near(self, ranked: Sequence[LinearFit], more: float) -> list[LinearFit]:
        """Models that may be as good as the best, but for those that say the same as one of fewer numbers."""
        least = self._linear_score(ranked[0])
        usual = _SLACK + _SHARE * max(self.bare_score - least, 0.0) + more
        found = []
        for each in ranked:
            slack = usual + _SWITCHED * each.switches
            if is_near(self._linear_score(each) - least, each.chi2 - ranked[0].chi2, slack):
                found.append(each)
        return [found[i] for i in without_idle_numbers(found)]

    def _chosen(self, fit: LinearFit) -> Chosen:
        """Terms with the strengths that the linear answers give them."""
        largest = tuple(map(self.missing.largest, fit.candidates))
        return Chosen(fit.candidates, tuple(fit.strengths.tolist()), largest)

    def _keep(self, model: Modelled) -> FittedTerms:
        score = model.fit.chi2 + self.price(model.numbers, len(model.chosen.candidates))
        tried = FittedTerms(model, score, lack_of_fit_p(model.fitter, model.fit))
        self._kept[model.chosen.key] = tried
        return tried


def _is_hopeless(found: FittedTerms | None) -> bool:
    """Whether a model is far from explaining the run."""
    return found is None or found.chance < _HOPELESS

"""Which causes, alone or together, explain the data: forward selection and replacement over sets.

The Gram matrices of every fit predict the gain of adding one or two causes, or of exchanging one. The most
promising sets are then fitted in full, until none is left that might be better, as README.md judges them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from types import MappingProxyType

import numpy as np

from warmlink.orchestration.diagnosis.fit import neighbours
from warmlink.orchestration.diagnosis.fit.candidates import Item
from warmlink.orchestration.diagnosis.fit.fitted import UNEXPLAINED, lack_of_fit_p
from warmlink.orchestration.diagnosis.fit.fitting import Fit, Fitter, held_at
from warmlink.orchestration.diagnosis.fit.neighbours import Neighbours, Proposal
from warmlink.orchestration.progress import Progress, unseen

FALSE_ALARMS = 0.007
"""Share of runs with nothing wrong in which some cause may reach the penalty."""

INVENTED = 0.002
"""Share of runs in which a cause may be added to those that are there."""

MOST_CAUSES = 3
NEAR = 7.0
"""Chi-square by which a set must be worse to be told apart from the best."""

_ALIKE = 0.1
"""Chi-square up to which sets differ by rounding alone; then the order of the catalogue decides."""

_STRONG = 20.0
"""Multiple of a cause's strength from which it is weak beside what two may be that cancel."""

_SLACK, _WINS = 6.0, 4.0
"""What a prediction may be off by, for a set of as many causes and for a larger one."""

_MOST_FITS, _PER_ROUND = 45, 4
"""Fits that a search may take, and those between two looks at what is most promising."""

PATIENT, IMPATIENT = 10, _PER_ROUND
"""Fits since the best one at which a hopeless search ends; fewer where the one before was hopeless too."""

HOPELESS = 1e-30
"""Chance level of what the best set leaves below which nothing will explain it."""

_ALONE, _MOST_ALONE = 0.3, 6
"""Share of the best set's gain that is expected of a cause for it to be fitted alone, and number of those."""


class Search:
    """Fits sets of causes until the best is found; `fits` has every fit made, by the titles of its causes.

    Parameters
    ----------
    before : fits of the same causes under another noise, from which the new ones begin
    alone : there are no causes to think of
    """

    def __init__(
        self,
        fitter: Fitter,
        progress: Progress = unseen,
        before: Mapping[frozenset[str], Fit] = MappingProxyType({}),
        alone: bool = False,
    ) -> None:
        self.fitter = fitter
        sought = (i for i in fitter.problem.items if not (i.cause.twin_of or i.cause.unsought))
        possible = [] if alone else list(sought)
        # The first of those that free the same in the fitted runs.
        split = ((_split(i, fitter.problem.fitted_runs), i) for i in reversed(possible))
        self.items = tuple(dict(split).values())[::-1]
        self.fits: dict[frozenset[str], Fit] = {}
        self._proposals: dict[frozenset[str], Proposal] = {}
        self._chances: dict[frozenset[str], float] = {}
        self._place = {item.title: i for i, item in enumerate(fitter.problem.items)}
        self._progress, self._before = progress, before
        begun = before.get(frozenset())
        self.add(fitter.fit((), begun.values if begun else None))

    @property
    def null(self) -> Fit:
        """The model with nothing but its calibration fitted."""
        return self.fits[frozenset()]

    @cached_property
    def level(self) -> float:
        """Probability below which a cause's gain counts, all candidates considered."""
        return neighbours.family_wise_level(Neighbours(self.null, self.items, ()), FALSE_ALARMS)

    @cached_property
    def _prices(self) -> dict[str, tuple[float, float]]:
        """What each candidate must gain in chi-square as the only cause, and as a further one."""
        from scipy.special import chdtri

        shares, further = neighbours.prior_shares(self.items), self.level * INVENTED / FALSE_ALARMS
        of = [(i, shares.get(i.cause.twin_of or i.cause.name, 1.0)) for i in self.fitter.problem.items]
        wanted = [(item.title, len(item.freed), share) for item, share in of]
        return {
            title: (float(chdtri(count, self.level * share)), float(chdtri(count, further * share)))
            for title, count, share in wanted
        }

    def penalty(self, items: Sequence[Item], alone: bool = False) -> float:
        """What a set must gain in chi-square; with each of its causes counted as if it were `alone`."""
        prices = [self._prices[item.title] for item in items]
        least = sum(first for first, _ in prices)
        if alone or len(prices) < 2:
            return least
        dearer = sum(further for _, further in prices) - least
        return least + dearer * (len(prices) - 1) / len(prices)

    def score(self, fit: Fit) -> float:
        """Chi-square plus penalty; infinite where a cause lies on its bound."""
        return fit.chi2 + self.penalty(fit.items) if fit.admissible else np.inf

    @property
    def best(self) -> Fit:
        """The fit of the lowest score; the first in the catalogue of several that are alike."""
        lowest = min(map(self.score, self.fits.values()))
        alike = [fit for fit in self.fits.values() if self.score(fit) <= lowest + _ALIKE]
        return min(alike, key=lambda fit: (len(fit.key), sorted(self._place[title] for title in fit.key)))

    def lack_of_fit_p(self, fit: Fit) -> float:
        """Chance level of what one of the fits leaves unexplained."""
        if fit.key not in self._chances:
            self._chances[fit.key] = lack_of_fit_p(self.fitter, fit)
        return self._chances[fit.key]

    def add(self, fit: Fit) -> None:
        """Keep a fit and note what it proposes."""
        self.fits[fit.key] = fit
        self._proposals.pop(fit.key, None)
        self._chances.pop(fit.key, None)
        for proposal in self._proposed_by(fit):
            known = self._proposals.get(proposal.key)
            covered = any(one.covers(other) for one in proposal.items for other in proposal.items)
            new = proposal.key not in self.fits and (known is None or proposal.chi2 < known.chi2)
            if new and not covered:
                self._proposals[proposal.key] = proposal

    def run(self, patience: int = PATIENT) -> Fit:
        """Search until no proposal may be better or as good, or so many fits were made.

        Parameters
        ----------
        patience : fits since the best one at which the search ends where nothing explains the data
        """
        alone: list[Proposal] = []
        late: list[Proposal] = []
        for clock in self._clocks if self.lack_of_fit_p(self.null) < UNEXPLAINED else ():
            if frozenset((clock.title,)) not in self.fits:
                self.add(self.fitter.fit((clock,)))
        while len(self.fits) < _MOST_FITS:
            best, bar = self.best, self.score(self.best)
            since = len(self.fits) - 1 - list(self.fits).index(best.key)
            hopeless = since >= patience and self.lack_of_fit_p(best) < HOPELESS
            worthy = [p for p in self._proposals.values() if p.chi2 < bar + self._excess(p, best)]
            promising = [] if hopeless else sorted(worthy, key=self._expected)[:_PER_ROUND]
            if not promising and not hopeless and not alone and self._doubtful(best):
                promising = alone = self._alone(best)
            if not promising and not late and self.lack_of_fit_p(best) < UNEXPLAINED:
                promising = late = self._late(best)
            if not promising:
                break
            for proposal in promising:
                told = f"set {len(self.fits)} of at most {_MOST_FITS}, {' + '.join(sorted(proposal.key))}"
                self._progress(f"causes: {told}", min(1.0, len(self.fits) / _MOST_FITS))
                near = len(proposal.items) > 1 and promising is not late
                worth = bar + self._excess(proposal, best) if near else np.inf
                before = self._before.get(proposal.key)
                start = before.values if before else proposal.start()
                self.add(self.fitter.fit(proposal.items, start, worth))
        return self.best

    def _doubtful(self, best: Fit) -> bool:
        """Whether a cause that promises less may be better: the best has several, or explains too little."""
        return len(best.items) > 1 or (bool(best.items) and self.lack_of_fit_p(best) < UNEXPLAINED)

    def _alone(self, best: Fit) -> list[Proposal]:
        """Single causes that may do as well: the linearisation is unreliable far from the start."""
        needed = self.null.chi2 - _ALONE * (self.null.chi2 - best.chi2)
        single = [p for p in self._proposals.values() if len(p.items) == 1 and p.chi2 < needed]
        return sorted(single, key=lambda p: p.chi2)[:_MOST_ALONE]

    @cached_property
    def _clocks(self) -> list[Item]:
        """Clocks of all logged columns, which are always tried if something is wrong.

        That all leaps come sooner counts as noise, so that what is linear in a clock promises nothing.
        """
        return [i for i in self.items if i.cause.kind == "record" and i.name == i.cause.name]

    def _late(self, best: Fit) -> list[Proposal]:
        """A clock error beside each cause of the best set, whose other causes may only mimic it."""
        pairs = (frozenset((clock.title, item.title)) for clock in self._clocks for item in best.items)
        return [self._proposals[pair] for pair in pairs if pair in self._proposals]

    def _excess(self, proposal: Proposal, best: Fit) -> float:
        """What a proposal's chi-square may have above the best score for the proposal to be worth a fit.

        Sets of as many causes matter when they come near, larger ones only when they win.
        """
        margin = _WINS if len(proposal.items) > len(best.items) else NEAR + _SLACK
        return margin - self.penalty(proposal.items)

    def rivals(self, best: Fit, within: float = NEAR) -> list[Fit]:
        """Other sets of as many causes that fit as well as the best, to within a chi-square."""
        size, bar = len(best.items), self.score(best) + within
        close = [fit for fit in self.fits.values() if len(fit.items) == size and self.score(fit) < bar]
        every = {twin.key: twin for fit in close for twin in (*self._twins(fit), fit)}
        every.pop(best.key, None)
        return sorted(every.values(), key=self.score)

    def extended(self, best: Fit) -> list[Fit]:
        """Sets with one more cause, which reach the level of a first cause but not that of a further one."""
        bar = best.chi2 + self.penalty(best.items, alone=True)
        more = [f for f in self.fits.values() if f.key > best.key and len(f.key) == len(best.key) + 1]
        likely = [f for f in more if f.admissible and f.chi2 + self.penalty(f.items, alone=True) < bar]
        return sorted(likely, key=self.score)

    def cancelling(self, best: Fit) -> list[Fit]:
        """Sets with one more cause that takes back nearly all of another, so that neither strength is known.

        So a cause that is found weak may be what is left of two strong ones.
        """
        found = []
        near = Neighbours(best, self.items, ())
        usable = [each for each in near.alone() if near.left[each[1]] < neighbours.MADE_UP_FOR]
        for other, _, rates in usable if len(best.items) < MOST_CAUSES else ():
            (freed,) = other.freed
            for weak in (f for item in best.items for f in item.freed if rates.get(f)):
                strength = best.values[weak] - weak.start
                against = freed.start + _STRONG * strength / rates[weak]
                if strength == 0 or not freed.lower <= against <= freed.upper:
                    continue
                items = (*best.items, other)
                fit = self.fitter.fit(held_at(against, freed, items), best.values)
                ratio = (fit.values[weak] - weak.start) / strength
                if fit.chi2 < best.chi2 + NEAR and ratio > _STRONG / 2:
                    found.append(replace(fit, items=items, freed=(*best.freed, freed)))
        return found

    def _twins(self, fit: Fit) -> Iterable[Fit]:
        """The same fit by other labels, or twins of causes, that no data of the fitted runs tell apart."""
        runs = self.fitter.problem.fitted_runs
        for i, item in enumerate(fit.items):
            for other in self.fitter.problem.items:
                if other.title not in fit.key and _split(other, runs) == _split(item, runs):
                    pairs = zip(other.freed, item.freed, strict=True)
                    if not all(own.lower <= fit.values[found] <= own.upper for own, found in pairs):
                        continue
                    items = (*fit.items[:i], other, *fit.items[i + 1 :])
                    freed = (*self.fitter.problem.calibrated, *(f for each in items for f in each.freed))
                    yield replace(fit, items=items, freed=freed)

    def not_fitted(self, count: int) -> list[Proposal]:
        """The most promising sets that were not fitted, best first."""
        return sorted(self._proposals.values(), key=self._expected)[:count]

    def _expected(self, proposal: Proposal) -> float:
        return proposal.chi2 + self.penalty(proposal.items)

    def _proposed_by(self, fit: Fit) -> Iterable[Proposal]:
        size = len(fit.items)
        for removed in ((), *((item,) for item in fit.items)):
            near = Neighbours(fit, self.items, removed)
            kept = tuple(item for item in fit.items if item not in removed)
            singles = near.singles() if len(kept) < MOST_CAUSES else ()
            pairs = near.pairs() if not removed and size + 2 <= MOST_CAUSES else ()
            fewer: list[tuple[int, ...]] = [()] if removed and kept else []
            yield from near.proposals(kept, [*singles, *pairs, *fewer])


def _split(item: Item, runs: Sequence[int]) -> tuple[object, ...]:
    """What an item frees in the fitted runs, whatever the label or a twin of its cause is called."""
    name = item.name.replace(item.cause.name, item.cause.twin_of or item.cause.name, 1)
    return name, tuple(tuple(r for r in f.runs if r in runs) for f in item.freed)

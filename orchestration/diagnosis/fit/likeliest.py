"""How much the surroundings wander: the amplitude of the largest likelihood, possible causes considered."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.fitting import Fit, FitPoint, Fitter
from warmlink.orchestration.diagnosis.fit.neighbours import Neighbours
from warmlink.orchestration.diagnosis.fit.search import Search
from warmlink.orchestration.diagnosis.fit.wandering import STILL, Responses, Wander, integrated_out

MEMORIES = (600.0, 1800.0)
ROOMS = (0.02, 0.035, 0.05, 0.07, 0.1, 0.14, 0.2, 0.28)
HEATS = (0.05, 0.1, 0.2)
"""Correlation times in s, and amplitudes in K and W that are ordinary; beyond them something is wrong."""

_WORTH, _LIKED, _HOPELESS = 6.0, 3.0, 10.0
"""Of twice the log-likelihood: the gain that each wandering signal must bring, the loss up to which an
amplitude is likely, and the loss beyond which it is not tried."""


def likeliest(search: Search, fits: Iterable[Fit]) -> tuple[Wander, Responses]:
    """How much wanders, judged from models, each with up to two further causes in linear approximation."""
    problem = search.fitter.problem
    tried: list[tuple[float, Wander, Responses]] = []
    for fit in fits:
        seen = Integrated(search, fit, Responses(problem, problem.values_by_run(fit.freed, fit.theta)))
        tried += [(seen.misfit(wander), wander, seen.responses) for wander in seen.candidates()]
    least, best, responses = min(tried, key=lambda each: each[0])
    if best.room == ROOMS[-1]:
        return STILL, responses  # no ordinary room: something else is wrong
    if best.room:
        # What may be only the room must not be called a finding: of what is about as likely, the strongest.
        liked = [each for each in tried if each[0] < least + _LIKED and each[1].heat == best.heat]
        _, best, responses = max(liked, key=lambda each: each[1].room ** 2 * each[1].memory)
    return best, responses


class Integrated:
    """A model's least score for any wandering, what wanders integrated out."""

    def __init__(self, search: Search, fit: Fit, responses: Responses) -> None:
        self.search, self.fit, self.responses = search, fit, responses
        fitter = search.fitter
        plain = fitter if fitter.wander.still else Fitter(fitter.problem, fitter.noise)
        self._grams = []
        for run, joined in enumerate(plain.whitened(fit.freed, fit.theta, every=True)):
            columns = plain.whiten(run, plain.stacked(run, responses.columns[run]))
            self._grams.append((joined.T @ joined, columns.T @ joined, columns.T @ columns))
        self._misfits: dict[Wander, float] = {}

    def candidates(self) -> list[Wander]:
        """Nothing and rooms that wander, the likely ones also with the likeliest heat."""
        tried = [STILL]
        for memory in MEMORIES if "room" in self.responses.signals else ():
            rooms: list[Wander] = []
            for room in ROOMS:
                rooms.append(Wander(room, 0.0, memory))
                # Along rooms alone: causes may imitate a weak one better than a still model does.
                if self.misfit(rooms[-1]) > min(map(self.misfit, rooms)) + _HOPELESS:
                    break  # and a stronger one is less likely still
            tried += rooms
        if "heat" not in self.responses.signals:
            return tried
        likeliest = min(tried, key=self.misfit)
        heat = min(HEATS, key=lambda each: self.misfit(replace(likeliest, heat=each)))
        likely = [each for each in tried if self.misfit(each) < self.misfit(likeliest) + _HOPELESS]
        return tried + [replace(each, heat=heat) for each in likely]

    def misfit_alone(self, wander: Wander) -> float:
        """Minus twice the log-likelihood of the model by itself, but for a constant."""
        point, constant = self._point(wander)
        return point.chi2 + constant

    def smoothed(self, run: int, wander: Wander) -> tuple[Array, Array]:
        """Values of the wandering signals at their nodes, shape (values,), and their covariance."""
        _, across, inner = self._grams[run]
        root = self.responses.root(run, wander)
        covariance = root @ np.linalg.solve(np.eye(len(root)) + root.T @ inner @ root, root.T)
        return covariance @ across[:, 0], covariance

    def misfit(self, wander: Wander) -> float:
        """Least score of the model, alone or with one or two further causes, found once."""
        if wander not in self._misfits:
            self._misfits[wander] = self._misfit(wander)
        return self._misfits[wander]

    def _misfit(self, wander: Wander) -> float:
        point, constant = self._point(wander)
        near = Neighbours(replace(self.fit, point=point), self.search.items, ())
        tried = near.proposals(self.fit.items, [(), *near.singles(), *near.pairs()])
        least = min(each.chi2 + self.search.penalty(each.items) for each in tried)
        return least + constant + _WORTH * ((wander.room > 0) + (wander.heat > 0))

    def _point(self, wander: Wander) -> tuple[FitPoint, float]:
        """Chi-square and its linearisation, and what else belongs to the likelihood."""
        if wander.still:
            return FitPoint.of([gram for gram, _, _ in self._grams]), 0.0
        roots = (self.responses.root(run, wander) for run in range(len(self._grams)))
        out = [integrated_out(*each, root) for each, root in zip(self._grams, roots, strict=True)]
        return FitPoint.of([gram for gram, _ in out]), sum(constant for _, constant in out)

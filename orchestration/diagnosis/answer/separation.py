"""What tells models apart: sets of causes that may replace each other, and how far apart a new run sets them.

The separation of a rival from the truth is the distance of the true readings from the nearest that the rival
can give, its numbers refitted (T-optimal design: A. C. Atkinson and V. V. Fedorov, Biometrika 62 (1975)
57-70). Where the truth holds, the rival's chi-square is larger by the separation's square, with a scatter of
twice the separation.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.names import listed
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.fit.algebra import orthonormal, root_of
from warmlink.orchestration.diagnosis.fit.fitted import Carried
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.fit.noise import NoiseModel, Whitener
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.scenarios.duties.duty import Segment, demands_at, length

Titles = frozenset[str]
Pair = tuple[Titles, Titles]

_MOST_TOLD = 4
"""Causes of a list that the words name."""

_CLOSE = 1e-6
"""Separation in standard deviations below which two models count as the same."""

_REST = Segment(900)
_FAST = Segment(1500, 4.5, 0.5)
_HEAVY = Segment(1500, 1.0, 5.0)
_STALL = Segment(1500, 0.0, 4.5)
_BOTH = Segment(1500, 3.43, 2.5)
_PAD = Segment.with_pad(1500, ROOM_TEMPERATURE + 35)
_LONG_REST = Segment(2700)
# Pad and winding heat together: the shaft becomes 45 K warm, the winding 80 K.
_HOT = Segment.with_pad(2700, ROOM_TEMPERATURE + 60, 0.0, 4.5)
_HOT_FAST = Segment.with_pad(2700, ROOM_TEMPERATURE + 60, 4.5, 2.5)

ONE_AT_A_TIME = (_FAST, _REST, _HEAVY, _REST, _PAD, _REST)
"""Fast without load, slow under load, and heated by a pad, with rests between."""

WITHOUT_PAD = ONE_AT_A_TIME[:4]
"""The same for a machine without a pad."""

DUTIES: tuple[tuple[Segment, ...], ...] = (
    (_REST, _BOTH, _LONG_REST, _FAST),
    ONE_AT_A_TIME,
    (_PAD, _LONG_REST, _STALL, _REST),
    (_HEAVY, _FAST, _HEAVY, _FAST),
    (_PAD, _FAST, _PAD, _REST),
    (_LONG_REST, _STALL, _FAST, _REST),
    (_STALL, _BOTH, _REST, _PAD),
    (_HOT, _LONG_REST),
    (_HOT_FAST, _LONG_REST),
    (_HOT, _REST, _HOT_FAST, _LONG_REST),
    (_HOT, _FAST, _LONG_REST),
    tuple(
        replace(s, duration=600.0)
        for s in (_FAST, _REST, _HEAVY, _REST, _STALL, _REST, _PAD, _REST, _BOTH, _REST, _FAST, _REST)
    ),
    tuple(replace(s, duration=300.0) for s in (_BOTH, _REST, _PAD, _REST, _FAST, _REST, _HEAVY, _REST) * 3),
)
"""Feasible duty cycles of one to three hours."""


def duties_of(rig: Rig) -> tuple[tuple[Segment, ...], ...]:
    """Feasible duty cycles of what a machine is driven by; none if neither speed nor torque."""
    return tuple(duty for duty in DUTIES if drives(duty, rig)) if drives((_FAST, _HEAVY), rig) else ()


def drives(duty: Sequence[Segment], rig: Rig) -> bool:
    """Whether a duty cycle drives a machine, which has the pads that the cycle needs."""
    moved = "speed" in rig.demanded or "torque" in rig.demanded
    return moved and ("pad_temperature" in rig.demanded or all(np.isnan(each.pad) for each in duty))


def problem_with(experiment: Experiment, runs: Iterable[Run]) -> tuple[Problem, int]:
    """A problem whose last runs were not made, with the labels of the first that was; how many stand before.

    Causes by label need runs with every value. Nothing was measured that a new run could start from.
    """
    labels = next(run for run in experiment.runs if not run.heldout).labels
    labelled = [run for run in experiment.runs if run.labels]
    every = (*labelled, *(replace(run, labels=labels) for run in runs))
    return Problem(replace(experiment, runs=every, initial_measured=False)), len(labelled)


def run_of(duty: Sequence[Segment], rig: Rig, variables: Sequence[str], share: float, interval: float) -> Run:
    """Run over the first share of a duty cycle, with a row for each interval in s; its readings are 0."""
    time = np.arange(0.0, share * length(duty) + interval / 2, interval)
    demands = demands_at(duty, time)
    inputs = {end: values for name, values in demands.items() for end in rig.demanded.get(name, ())}
    return Run("next", time, inputs, {v: np.zeros(time.size) for v in variables})


class Foreseen:
    """Predictions of a problem's last run by models of other runs, in standard deviations of its noise."""

    def __init__(self, problem: Problem, noise: Sequence[NoiseModel], models: Sequence[Fit]) -> None:
        self.models = tuple(models)
        run = len(problem.data) - 1
        whiten = [Whitener(n, problem.data[run].time) for n in noise]
        self._readings, self._columns = [], []
        for fit in self.models:
            carried = Carried(problem, fit)
            each = np.concatenate([carried.predict(run)[0][:, :, None], carried.by(run, fit.freed)], axis=2)
            # Readings and their derivatives by the fit's numbers, all channels after one another.
            together = np.concatenate([w(each[:, i]) for i, w in enumerate(whiten)])
            self._readings.append(together[:, 0])
            self._columns.append(together[:, 1:])
        self._bases = [orthonormal(columns) for columns in self._columns]

    def separations(self, truths: int) -> Array:
        """Separation of every model from each of the first so many, as the truth, shape (truths, models).

        Infinite where the rival is the truth with further causes, which fits as well and needs more.
        """
        table = np.full((truths, len(self.models)), np.inf)
        for i, truth in enumerate(self.models[:truths]):
            for j, rival in enumerate(self.models):
                if not rival.key >= truth.key:
                    apart = self._readings[i] - self._readings[j]
                    taken = self._bases[j]
                    table[i, j] = np.linalg.norm(apart - taken @ (taken.T @ apart))
        return table

    def pooled_separation(self, rival: int) -> float:
        """Separation of a model from the first, where both models' numbers are known from fitted runs too."""
        apart = self._readings[0] - self._readings[rival]
        columns = [self._columns[i] @ root_of(self.models[i].covariance()) for i in (0, rival)]
        free = np.column_stack(columns)
        # (I + F F')^-1 by Woodbury's identity
        part = free.T @ apart
        rest = apart @ apart - part @ np.linalg.solve(np.eye(free.shape[1]) + free.T @ free, part)
        return float(np.sqrt(np.maximum(rest, 0.0)))


def chances(separations: Array, needed: Array) -> Array:
    """Chance that each truth is told from the rival that is nearest to it, shape (truths,).

    By the separation of each rival from each truth, and by how much the rival's chi-square must be larger,
    shape (truths, models) each.
    """
    from scipy.special import ndtr

    away = np.where(np.isfinite(separations), np.maximum(separations, _CLOSE), 1.0)
    beyond = np.where(np.isfinite(separations), (away**2 - needed) / (2 * away), np.inf)
    nearest: Array = np.min(beyond, axis=1)
    return np.asarray(ndtr(nearest))


def stand_ins(best: Titles, rivals: Sequence[Titles]) -> list[list[str]]:
    """Causes that the data cannot tell apart, one of the best set first in each list.

    Two sets that differ in one cause show that these two causes may replace each other. A set that follows
    from the best one by such exchanges is not listed again; any other is, as a combination written `a+b`.
    Sets are titles of causes, rivals best first.
    """
    members = (best, *rivals)
    group = {title: {title} for member in members for title in member}
    for one, other in combinations(members, 2):
        (gone, come) = one - other, other - one
        if len(gone) == len(come) == 1:
            joined = group[next(iter(gone))] | group[next(iter(come))]
            group.update(dict.fromkeys(joined, joined))
    order = list(dict.fromkeys(title for member in members for title in sorted(member)))
    told: dict[Titles, list[str]] = {}
    for title in sorted(best, key=order.index):
        if len(group[title]) > 1:
            told.setdefault(
                frozenset(group[title]), [title, *(t for t in order if t in group[title] and t != title)]
            )
    for rival in sorted(rivals, key=lambda each: len(each - best)):
        own, other = best - rival, rival - best
        if not own:  # the same causes, and perhaps one more
            own, other = best, rival
        elif {id(group[title]) for title in own} == {id(group[title]) for title in other}:
            continue
        told.setdefault(own, [*titles([own])]).extend(titles([other]))
    return list(told.values())


def titles(sets: Iterable[Titles]) -> tuple[str, ...]:
    """Each set of causes as it is written, `a+b`."""
    return tuple("+".join(sorted(each)) for each in sets)


def differences(best: Titles, rivals: Sequence[Titles]) -> list[tuple[str, ...]]:
    """Causes in which each rival differs from the best set: those it lacks, and those it has instead.

    One side is empty where a rival has only more or only fewer causes. A difference that contains another
    one is left out.
    """
    found = list(dict.fromkeys((best - rival, rival - best) for rival in rivals))
    within = [(a, b) for a, b in found if a and b]
    return [
        titles((own, other))
        for own, other in found
        if not any(a <= own and b <= other and (a, b) != (own, other) for a, b in within)
    ]


def told_apart(best: Titles, rivals: Sequence[Titles]) -> str:
    """What tells the best set from rivals, in words; empty where there are none."""
    return ", and ".join(_in_words(differences(best, rivals)))


def indistinguishable(alike: Iterable[Pair]) -> str:
    """A sentence, after a blank, on sets that nothing tells apart; empty where there are none."""
    told: dict[frozenset[str], tuple[str, ...]] = {}
    for pair in (pair for one, other in alike for pair in differences(one, [other])):
        told.setdefault(frozenset(pair), pair)
    words = _in_words(told.values())
    return f" Nothing tells {', nor '.join(words)}." if words else ""


def _in_words(pairs: Iterable[tuple[str, ...]]) -> list[str]:
    """Differences in words, those of one cause together."""
    others: dict[str, list[str]] = {}
    for one, other in pairs:
        others.setdefault(one or other, []).append(other if one else "")
    words = []
    for one, each in others.items():
        names = [other for other in each if other]
        if len(names) < len(each):
            words.append(f"whether {one} is there")
        if len(names) > _MOST_TOLD + 1:
            names = [*names[:_MOST_TOLD], f"{len(names) - _MOST_TOLD} more"]
        if names:
            words.append(f"{one} from {listed(names, 'or')}")
    return words

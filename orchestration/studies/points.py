"""Points of a study, run and judged: chosen by tuning, or all those of a grid or a Latin hypercube."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import Answer
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.study import Point, Study
from warmlink.orchestration.studies.workers import Workers

AT_ONCE = 1000
"""Points whose runs are laid out in memory, some 10 kB for each run."""

SPREAD = 16
"""Trials before the sampler goes by results: two batches of 8, which hold the 10 that Optuna asks for."""

OBJECTIVES = "objective", "second_objective"
"""What results call them."""

Progress = Callable[[int], None]
"""Called with the number of points done."""


@dataclass(frozen=True)
class Judged:
    """What a point came to; points are numbered from 0 in their study.

    Where there are no objectives, `reason` says why. By `excess` each constraint is exceeded, 0 or below
    where it is kept. Outcomes are in the order of `Study.runs`; there are none where a component refused the
    point, nor of trials read back from a storage.
    """

    number: int
    point: Point
    objectives: tuple[float, ...] = ()
    excess: tuple[float, ...] = ()
    reason: str | None = None
    outcomes: tuple[Outcome, ...] = field(default=(), repr=False, compare=False)

    @property
    def feasible(self) -> bool:
        """Whether there is an objective and every constraint is kept."""
        return self.reason is None and all(excess <= 0 for excess in self.excess)

    @property
    def objective(self) -> float:
        """The first one; NaN where there is none."""
        return self.objectives[0] if self.objectives else math.nan

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "number": self.number,
            "parameters": dict(self.point),
            **dict(zip(OBJECTIVES, self.objectives or (None,), strict=False)),
            "feasible": self.feasible,
            "reason": self.reason,
        }


def front(found: Sequence[Judged]) -> list[Judged]:
    """The feasible points that no other one betters in both objectives, by the first one.

    With one objective that is the best alone, the earliest of equals.
    """
    fit = sorted((each for each in found if each.feasible), key=lambda each: each.objectives)
    least = np.minimum.accumulate([math.inf, *(each.objectives[-1] for each in fit)])
    return [each for each, better in zip(fit, np.diff(least) < 0, strict=True) if better]


def best(found: Sequence[Judged]) -> Judged | None:
    """The best point that keeps every constraint; None if there is none.

    With two objectives it is the one of the front that is closest to the least of both, each measured by the
    span that it has in the front.
    """
    kept = front(found)
    if len(kept) < 2:
        return kept[0] if kept else None
    reached = np.array([each.objectives for each in kept])
    shares = (reached - np.min(reached, axis=0)) / np.ptp(reached, axis=0)
    return kept[int(np.argmin(np.hypot(*shares.T)))]


def nearest(study: Study, found: Sequence[Judged]) -> Judged | None:
    """The point that breaks its worst constraint least, as a share of the bound; None if there is none."""

    def broken(each: Judged) -> float:
        pairs = zip(study.constraints, each.excess, strict=True)
        return max((excess / (abs(of.at_most) or 1.0) for of, excess in pairs), default=math.inf)

    return min((each for each in found if each.reason is None), key=broken, default=None)


@dataclass(frozen=True, repr=False)
class Searched(Answer):
    """A study and what its points came to, by number; `word` is what one of them is called."""

    study: Study
    found: list[Judged]
    word: ClassVar[str] = "point"

    @property
    def best(self) -> Judged | None:
        """The best that keeps every constraint; None if there is none."""
        return best(self.found)

    @property
    def unmet(self) -> list[str]:
        """That nothing keeps every constraint, and what comes nearest to it."""
        told, close = f"no {self.word} keeps every constraint", nearest(self.study, self.found)
        if close is None:
            return [told]
        missed = [
            f"{of.title} {of.at_most + excess:.4g}, {excess:.4g} above {of.at_most:g}"
            for of, excess in zip(self.study.constraints, close.excess, strict=True)
            if excess > 0
        ]
        where = f"nearest is {self.word} {close.number}: {'; '.join(missed)}"
        return [told, where, *self.study.lines(close.point)]

    def summary(self) -> str:
        """What came of the study, in a few lines."""
        study, poisoned = self.study, [each for each in self.found if each.reason is not None]
        head = f"{study.title} · {study.controller.name} · {len(self.found)} {self.word}s "
        lines = [f"{head}of {len(study.runs)} runs", *self._best_lines()]
        if poisoned:
            because = f"the first because of: {poisoned[0].reason}"
            lines.append(f"{len(poisoned)} {self.word}s gave no objective, {because}")
        return "\n".join(lines)

    def _best_lines(self) -> list[str]:
        objectives = [each.objective for each in self.found if each.reason is None]
        if self.best is None:
            return self.unmet
        which = "amid the front" if self.study.objectives[1:] else "smallest that keeps every constraint"
        return [
            f"{self.study.objective.title}: from {min(objectives):.4g} to {max(objectives):.4g}",
            f"{which}: {self.best.objective:.4g}, {self.word} {self.best.number}",
            *self.study.lines(self.best.point),
            *self._front_lines(),
        ]

    def _front_lines(self) -> list[str]:
        """The front of two objectives."""
        titles = [each.title for each in self.study.objectives]
        if len(titles) < 2:
            return []
        return [f"front, by {' and '.join(titles)}"] + [
            f"  {self.word} {each.number:<6}" + "".join(f"{value:>12.4g}" for value in each.objectives)
            for each in front(self.found)
        ]

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "study": self.study.name,
            **dict(zip(OBJECTIVES, (each.title for each in self.study.objectives), strict=False)),
            "best": None if self.best is None else self.best.to_dict(),
            "units": {axis.name: axis.unit for axis in self.study.axes},
            f"{self.word}s": [each.to_dict() for each in self.found],
        }


def evaluate(study: Study, points: Sequence[Point], workers: Workers, first: int = 0) -> Iterator[Judged]:
    """Run points, numbered from the first, and give what each came to, in the order in which they end."""
    planned: dict[int, list[Case]] = {}
    for number, point in enumerate(points, first):
        try:
            planned[number] = study.cases(point, f"point {number}")
        except InputError as fault:
            yield Judged(number, point, reason=str(fault))
    places = [(number, run) for number, mine in planned.items() for run in range(len(mine))]
    found: dict[int, dict[int, Outcome]] = {}
    for place, outcome in workers.run([planned[number][run] for number, run in places]):
        number, run = places[place]
        mine = found.setdefault(number, {})
        mine[run] = outcome
        if len(mine) == len(planned[number]):
            outcomes = tuple(mine[run] for run in sorted(found.pop(number)))
            yield _judged(study, number, points[number - first], outcomes, planned[number])


def _judged(
    study: Study, number: int, point: Point, outcomes: tuple[Outcome, ...], cases: Sequence[Case]
) -> Judged:
    """Objective and constraints of a point whose runs are done."""
    for outcome, case in zip(outcomes, cases, strict=True):
        if outcome.stopped is not None:
            reason = f"{', '.join(case.label[1:])}: {outcome.stopped}"
            return Judged(number, point, reason=reason, outcomes=outcomes)
    objectives = tuple(each.value(outcomes, cases) for each in study.objectives)
    excess = tuple(constraint.excess(outcomes, cases) for constraint in study.constraints)
    told = zip((*study.objectives, *study.constraints), (*objectives, *excess), strict=True)
    for figure, value in told:
        if not math.isfinite(value):
            return Judged(number, point, reason=f"{figure.title} is {value}", outcomes=outcomes)
    return Judged(number, point, objectives, excess, None, outcomes)


def latin_hypercube(study: Study, count: int) -> list[Point]:
    """So many points spread over the bounds: along each axis one in each of `count` equal shares."""
    from scipy.stats import qmc

    shares = qmc.LatinHypercube(len(study.axes), seed=study.seed).random(count)
    return [
        {axis.name: axis.at(float(at)) for axis, at in zip(study.axes, row, strict=True)} for row in shares
    ]


def first_points(study: Study) -> list[Point]:
    """What ships, so that the table shows what tuning gains, and points spread over the bounds to learn from.

    Optuna would draw these at random. Few random points cluster: of 48 trials a third went into one corner.
    """
    first = [] if study.shipped is None else [study.shipped]
    return first + (latin_hypercube(study, SPREAD - len(first)) if study.tune.sampler == "tpe" else [])


def refuse_without_objective(study: Study, workers: Workers) -> None:
    """Refuse a study whose first point gives no objective: hardly any other would."""
    point = study.shipped or {axis.name: axis.at(0.5) for axis in study.axes}
    for probe in evaluate(study, [point], workers):
        if probe.reason is not None:
            where = "as shipped" if study.shipped else "in the middle of its bounds"
            raise InputError(f"{study.name}: there is no objective {where}: {probe.reason}; mend the study")

"""Points of a study run and judged: the part that tuning and sweeping share."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from warmlink.fmus.errors import InputError
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.cores.workers import Workers
from warmlink.orchestration.studies.study import Point, Study


@dataclass(frozen=True)
class Judged:
    """What a point came to.

    Attributes
    ----------
    objective : NaN where there is none
    excess : by how much each constraint is exceeded, 0 or below where it is kept
    reason : why there is no objective, None where there is one
    """

    point: Point
    objective: float
    excess: tuple[float, ...]
    reason: str | None

    @property
    def feasible(self) -> bool:
        """Whether there is an objective and every constraint is kept."""
        return self.reason is None and all(excess <= 0 for excess in self.excess)

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "parameters": dict(self.point),
            "objective": None if math.isnan(self.objective) else self.objective,
            "feasible": self.feasible,
            "reason": self.reason,
        }


@dataclass(frozen=True)
class Evaluation(Judged):
    """A point and its runs, in the order of `Study.runs`; no runs where a component refused the point."""

    outcomes: tuple[Outcome, ...]


AnyJudged = TypeVar("AnyJudged", bound=Judged)


def best(found: Sequence[AnyJudged]) -> AnyJudged | None:
    """The feasible point with the smallest objective, the earliest of equals; None where there is none."""
    return min((each for each in found if each.feasible), key=lambda each: each.objective, default=None)


def latin_hypercube(study: Study, count: int) -> list[Point]:
    """So many points spread over the bounds: along each axis one in each of `count` equal shares."""
    from scipy.stats import qmc

    shares = qmc.LatinHypercube(len(study.axes), seed=study.seed).random(count)
    return [
        {axis.name: axis.at(float(share)) for axis, share in zip(study.axes, row, strict=True)}
        for row in shares
    ]


def evaluate(study: Study, points: Sequence[Point], workers: Workers) -> Iterator[tuple[int, Evaluation]]:
    """Run points and give each one's place and what it came to, in the order in which they end."""
    cases: list[Case] = []
    owner: list[int] = []
    runs = len(study.runs)
    found: dict[int, list[Outcome | None]] = {}
    for i, point in enumerate(points):
        try:
            mine = study.cases(point, f"point {i}")
        except InputError as fault:
            yield i, Evaluation(point, math.nan, (), str(fault), ())
            continue
        found[i] = [None] * runs
        owner += [i] * runs
        cases += mine
    first = {i: place for place, i in reversed(list(enumerate(owner)))}
    for place, outcome in workers.run(cases):
        i = owner[place]
        found[i][place - first[i]] = outcome
        if all(each is not None for each in found[i]):
            outcomes = tuple(each for each in found.pop(i) if each is not None)
            yield i, judged(study, points[i], outcomes, cases[first[i] : first[i] + runs])


def judged(study: Study, point: Point, outcomes: tuple[Outcome, ...], cases: Sequence[Case]) -> Evaluation:
    """Objective and constraints of a point whose runs are done."""
    for outcome, case in zip(outcomes, cases, strict=True):
        if outcome.stopped is not None:
            where = ", ".join(case.label[1:])
            return Evaluation(point, math.nan, (), f"{where}: {outcome.stopped}", outcomes)
    objective = study.objective.value(outcomes, cases)
    excess = tuple(constraint.excess(outcomes, cases) for constraint in study.constraints)
    if not all(math.isfinite(value) for value in (objective, *excess)):
        return Evaluation(point, math.nan, (), f"{study.objective.title} is {objective}", outcomes)
    return Evaluation(point, objective, excess, None, outcomes)

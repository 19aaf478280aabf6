"""The next experiment: the feasible duty cycle that soonest tells apart what this one could not.

README.md says how it is chosen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.answer.separation import (
    ONE_AT_A_TIME,
    WITHOUT_PAD,
    Foreseen,
    chances,
    drives,
    duties_of,
    indistinguishable,
    problem_with,
    run_of,
    titles,
    told_apart,
)
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.thinning import MOST_ROWS, Averaging
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.search import NEAR
from warmlink.orchestration.diagnosis.fit.verdict import Assessment
from warmlink.orchestration.scenarios.duties.duty import Segment, length

MOST_RIVALS = 12
FURTHER = 30.0
"""Chi-square within which a model that these data rule out is still considered."""

SURE = 0.96
"""Expected chance of naming the cause that is enough."""

_POINTS = 9
"""Strengths of an effect over which a chance is averaged."""

ROUNDS = (1, 2, 3, 4, 6, 8, 12, 16, 24)
LONGEST = 86400.0
"""How often a duty cycle may be repeated, and s that all of it may take."""

_MORE = 0.01
"""Chance by which more rounds must be surer, to be worth their time."""

_TOGETHER = 0.8
"""Correlation of two inputs above which their effects are told apart badly."""

ALIKE = float(np.sqrt(NEAR))
"""Expected separation in standard deviations below which models are more likely than not to stay alike."""


@dataclass(frozen=True)
class Proposed:
    """What to do next.

    Attributes
    ----------
    duty : segments in order; empty where another kind of run is proposed, or nothing helps
    why : what it tells apart
    expected_separation_sigma : of the two nearest members that it tells apart; None where there are none
    expected_chance : of naming the cause, but for those that nothing tells apart; None where none is foreseen
    alike : pairs of sets of causes that no feasible duty cycle tells apart
    """

    duty: tuple[Segment, ...]
    why: str
    expected_separation_sigma: float | None
    expected_chance: float | None
    alike: tuple[tuple[str, str], ...] = ()

    @property
    def cycle(self) -> tuple[tuple[Segment, ...], int]:
        """Shortest cycle that the duty repeats, and how often."""
        count = len(self.duty)
        for size in range(1, count):
            if count % size == 0 and self.duty == self.duty[:size] * (count // size):
                return self.duty[:size], count // size
        return self.duty, 1


def next_experiment(assessment: Assessment, experiment: Experiment) -> Proposed | None:
    """Choose what tells the members of an ambiguous set apart, or shows what an unknown cause goes with.

    None where nothing is left to tell.
    """
    if assessment.word == "unknown":
        return _one_at_a_time(experiment)
    if not assessment.rivals:
        return None
    members = (assessment.best, *assessment.rivals[:MOST_RIVALS])
    feasible = duties_of(experiment.rig)
    if not feasible:
        return _another_run(assessment, members, experiment)
    design = _Design(assessment, experiment, members)
    table = np.array([design.separations(duty) for duty in feasible])
    most = np.sqrt([_rounds_within_a_day(duty)[-1] for duty in feasible])
    never = np.max(table * most[:, None, None], axis=0) < ALIKE
    pairs = list(combinations(range(len(members)), 2))
    alike = [(members[i].key, members[j].key) for i, j in pairs if never[i, j] or never[j, i]]
    written = tuple((one, other) for one, other in map(titles, alike))
    if len(alike) == len(pairs):
        shared = frozenset.intersection(*(fit.key for fit in members))
        items = {item.title: item for fit in members for item in fit.items if item.title not in shared}
        told = f"{' and '.join(items)} apart" if len(items) > 1 else f"whether {next(iter(items))} is there"
        first = next((item for item in items.values() if item.cause.twin_of), next(iter(items.values())))
        check = first.cause.check
        return Proposed((), f"No duty cycle of up to a day tells {told}. {check}", 0.0, 0.0, written)
    table[:, never] = np.inf
    duty, separations, chance = _surest(design, feasible, table, never)
    among = separations[:, : len(members)]
    nearest = float(np.minimum(among, among.T).min())
    best, *others = (fit.key for fit in members)
    told = told_apart(best, [key for key in others if (best, key) not in alike])
    why = (
        f"In {length(duty) / 3600:.1f} hours it {f'tells {told}' if told else 'narrows the set down'}, "
        f"with a chance of {100 * chance:.0f} %.{indistinguishable(alike)}"
    )
    return Proposed(duty, why, nearest, chance, written)


def _one_at_a_time(experiment: Experiment) -> Proposed | None:
    """A duty cycle in which what warms a machine up comes one at a time; None if nothing drives it."""
    duty: tuple[Segment, ...] = ONE_AT_A_TIME
    rig, heated = experiment.rig, "load, then is heated by a pad"
    if not drives(duty, rig):
        duty, heated = WITHOUT_PAD, "load"
    if not drives(duty, rig):
        return None
    why = (
        f"In {length(duty) / 3600:.1f} hours the motor turns fast without load, then slowly under "
        f"{heated}, with rests between, so that what no cause explains shows with one of "
        "them, or with none."
    )
    inputs = next(run for run in experiment.runs if not run.heldout).inputs
    speed, torque = (
        np.abs(inputs.get(next(iter(rig.demanded.get(name, ())), ""), np.zeros(1)))
        for name in ("speed", "torque")
    )
    if speed.size == torque.size and speed.std() > 0 and torque.std() > 0:
        together = float(np.corrcoef(speed, torque)[0, 1])
        if together > _TOGETHER:
            why += f" In this run speed and torque change together (correlation {together:.2f})."
    return Proposed(duty, why, None, None)


class _Design:
    """Predictions by the members of an ambiguous set, and by further models that must be ruled out."""

    def __init__(self, assessment: Assessment, experiment: Experiment, members: Sequence[Fit]) -> None:
        search = assessment.search
        known = {fit.key for fit in members}
        # The new run is judged by itself, so it must also rule out what these data only just rule out.
        further = [fit for fit in search.rivals(assessment.best, FURTHER) if fit.key not in known]
        self.members = len(members)
        self.models = [*members, search.null, *further[: MOST_RIVALS - self.members + 1]]
        self._assessment, self._experiment = assessment, experiment
        scores = np.array([search.score(fit) for fit in members])
        likelihood = np.exp(-0.5 * (scores - scores.min()))
        self._weights: Array = likelihood / likelihood.sum()
        price = np.array([search.penalty(fit.items) for fit in self.models])
        size = np.array([len(fit.items) for fit in self.models])
        alike = np.where(size[: self.members, None] == size, NEAR, 0.0)
        self._needed: Array = price[: self.members, None] - price + alike
        self._doubt = np.array([1 / np.sqrt(max(search.null.chi2 - fit.chi2, 1.0)) for fit in members])

    def separations(self, duty: Sequence[Segment]) -> Array:
        """Separation of each model from each member as the truth, shape (members, models)."""
        problem = self._assessment.problem
        measured = next(run for run in self._experiment.runs if not run.heldout)
        share = min(measured.fit_until / float(measured.time[-1]), 1.0)
        spacing = float(np.median(np.diff(problem.data[0].time)))
        interval = max(spacing, share * length(duty) / MOST_ROWS)
        run = run_of(duty, self._experiment.rig, problem.variables, share, interval)
        # The mean over an interval scatters less than a row does.
        known = problem.averaging
        here = Averaging(known.rows * interval / spacing, interval) if interval > spacing else known
        noise = [n.averaged(here, known) for n in self._assessment.noise]
        there, _ = problem_with(self._experiment, [run])
        return Foreseen(there, noise, self.models).separations(self.members)

    def chance(self, separations: Array) -> float:
        """Expected chance that the member which is true is named.

        The strength of an effect is uncertain by its standard deviation, and the separations are in
        proportion to it.
        """
        points, shares = np.polynomial.hermite_e.hermegauss(_POINTS)
        total = np.zeros(self.members)
        for point, share in zip(points, shares / shares.sum(), strict=True):
            strength = np.maximum(1 + point * self._doubt, 0.01)[:, None]
            total += share * chances(separations * strength, self._needed)
        return min(float(self._weights @ total), 1.0)


def _rounds_within_a_day(duty: Sequence[Segment]) -> list[int]:
    return [n for n in ROUNDS if n * length(duty) <= LONGEST]


def _surest(
    design: _Design, duties: Sequence[tuple[Segment, ...]], table: Array, never: NDArray[np.bool_]
) -> tuple[tuple[Segment, ...], Array, float]:
    """Duty cycle that is sure soonest, else the shortest that comes closest; its separations, and the chance.

    Separations are taken to grow with the root of the rounds; of the chosen cycle they are predicted.
    """
    found = []
    for which, separations in enumerate(table):
        for rounds in _rounds_within_a_day(duties[which]):
            chance = design.chance(separations * np.sqrt(rounds))
            found.append((round(max(SURE - chance, 0.0), 2), rounds * length(duties[which]), which, rounds))
            if chance >= SURE:
                break
    *_, which, least = min(found)
    cycle = duties[which]
    best = cycle, table[which], -1.0
    for rounds in (n for n in _rounds_within_a_day(cycle) if n >= least):
        separations = np.where(never, np.inf, design.separations(cycle * rounds))
        chance = design.chance(separations)
        if chance < best[2] + _MORE:
            break
        best = cycle * rounds, separations, chance
        if chance >= SURE:
            break
    return best


def _another_run(assessment: Assessment, members: Sequence[Fit], experiment: Experiment) -> Proposed:
    """Propose a run with labels in a combination that was not fitted yet."""
    runs = [run for run in experiment.runs if not run.heldout]
    names = [name for name in runs[0].labels if all(name in run.labels for run in runs)]
    values = [list(dict.fromkeys(run.labels[n] for run in runs)) for n in names]
    tried = {tuple(run.labels[n] for n in names) for run in runs}
    found: list[tuple[int, float, tuple[str, ...], Array]] = []
    for labels in (c for c in product(*values) if c not in tried):
        like = replace(
            runs[0], name="next", labels={**runs[0].labels, **dict(zip(names, labels, strict=True))}
        )
        problem = Problem(replace(experiment, runs=(*runs, like)))
        foreseen = Foreseen(problem, problem.noise_in(len(runs), assessment.noise), members)
        told = np.array([foreseen.pooled_separation(j) for j in range(1, len(members))])
        clear = told[told >= ALIKE]
        found.append((clear.size, float(clear.min(initial=np.inf)), labels, told))
    if not found or max(found)[0] == 0:
        why = f"No further run of this kind tells {members[0].name} from its rivals."
        return Proposed((), why, 0.0, 0.0)
    _, separation, labels, told = max(found)
    best, *others = (fit.key for fit in members)
    alike = [(best, key) for key, size in zip(others, told, strict=True) if size < ALIKE]
    words = " and ".join(f"{n} = {v}" for n, v in zip(names, labels, strict=True))
    apart = told_apart(best, [key for key in others if (best, key) not in alike])
    why = (
        f"In the fitted runs {' and '.join(names)} change together, so their effects cannot be told apart; "
        f"a run with {words} would tell {apart}.{indistinguishable(alike)}"
    )
    chance = float(chances(np.array([[separation]]), np.array([[NEAR]]))[0])
    return Proposed((), why, separation, chance, tuple((a, b) for a, b in map(titles, alike)))

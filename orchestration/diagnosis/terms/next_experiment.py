"""The next experiment for a set of equations: the feasible duty cycle that sets them furthest apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.answer.next_experiment import ALIKE, LONGEST, ROUNDS, SURE, Proposed
from warmlink.orchestration.diagnosis.answer.separation import chances, drives, duties_of, run_of
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.thinning import MOST_ROWS, Averaging
from warmlink.orchestration.diagnosis.fit.algebra import orthonormal
from warmlink.orchestration.diagnosis.fit.fitted import Carried
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.fit.noise import Whitener
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.search import NEAR
from warmlink.orchestration.diagnosis.fit.verdict import Assessment
from warmlink.orchestration.scenarios.duties.duty import Segment, length

_MOST_APART, _MOST_DUTIES = 4, 6
"""Members that are told apart, and duty cycles of the usual ones that are tried beside the staircases."""

_STAIRS = (
    tuple(Segment(900, speed, 0.5) for speed in (0.6, 4.2, 1.2, 3.6, 1.8, 3.0, 2.4, 0.0)),
    tuple(Segment(900, 1.0, torque) for torque in (0.5, 5.0, 1.0, 4.0, 2.0, 3.0, 0.0)),
    tuple(
        Segment(700, speed, torque)
        for speed, torque in ((0.6, 4.3), (4.2, 0.5), (0.6, 0.5), (2.4, 4.3), (1.2, 2.0), (3.6, 3.0), (0, 0))
    ),
)
"""Many levels of speed, of torque, and of both apart: powers, dead zones and switches differ between them."""


@dataclass(frozen=True)
class Rival:
    """A model that may be the truth: a fit, and the experiment whose machine has what it fits."""

    experiment: Experiment
    fit: Fit


def next_for(rivals: Sequence[Rival], assessment: Assessment) -> Proposed | None:
    """Propose a duty cycle that tells models apart, best first; None where nothing can be driven.

    Parameters
    ----------
    rivals : models that the data cannot tell apart
    assessment : the noise of the readings, and the rows that were fitted
    """
    some = rivals[:_MOST_APART]
    rig = assessment.problem.experiment.rig
    stairs = [duty for duty in _STAIRS if drives(duty, rig)]
    feasible = [*stairs, *duties_of(rig)[:_MOST_DUTIES]]
    if len(some) < 2 or not feasible:
        return None
    tables = [(_separations(some, duty, assessment), duty) for duty in feasible]
    most = [max(n for n in ROUNDS if n * length(duty) <= LONGEST) for _, duty in tables]
    told = [float(_chances(table * np.sqrt(n)).mean()) for (table, _), n in zip(tables, most, strict=True)]
    table, duty = tables[int(np.argmax(told))]
    clear = np.isfinite(table) & (table * np.sqrt(most[int(np.argmax(told))]) >= ALIKE)
    if not clear.any():
        return Proposed((), "No duty cycle of up to a day tells these explanations apart.", 0.0, 0.0)
    rounds = 1
    for rounds in (n for n in ROUNDS if n * length(duty) <= LONGEST):
        chance = float(_chances(table[clear] * np.sqrt(rounds)).mean())
        if chance >= SURE:
            break
    hours, pairs = rounds * length(duty) / 3600, int(clear.sum()) // 2
    every = len(some) * (len(some) - 1) // 2
    which = "them" if pairs == every else f"{pairs} of {every} pairs of them"
    why = (
        f"In {hours:.1f} hours it tells {which} apart, with a chance of {100 * chance:.0f} %: "
        "it goes through levels of speed and torque at which they give different heat."
    )
    nearest = float(table[clear].min()) * float(np.sqrt(rounds))
    return Proposed(duty * rounds, why, nearest, chance)


def _chances(separations: Array) -> Array:
    """Chance that each pair is told apart, by its separation, for those that are no model and itself."""
    finite = separations[np.isfinite(separations)]
    return chances(finite[:, None], np.full((finite.size, 1), NEAR))


def _separations(rivals: Sequence[Rival], duty: Sequence[Segment], assessment: Assessment) -> Array:
    """Separation in standard deviations of each model from each other as the truth; infinite of itself."""
    seen = [_seen(each, duty, assessment) for each in rivals]
    table = np.full((len(seen), len(seen)), np.inf)
    for i, (truth, _) in enumerate(seen):
        for j, (rival, basis) in enumerate(seen):
            if i != j:
                apart = truth - rival
                table[i, j] = np.linalg.norm(apart - basis @ (basis.T @ apart))
    return table


def _seen(rival: Rival, duty: Sequence[Segment], assessment: Assessment) -> tuple[Array, Array]:
    """What a model foresees in a duty cycle, and a basis of what its numbers may change, in noise."""
    problem, known = assessment.problem, assessment.problem.averaging
    spacing = float(np.median(np.diff(problem.data[0].time)))
    interval = max(spacing, length(duty) / MOST_ROWS)
    run = run_of(duty, rival.experiment.rig, problem.variables, 1.0, interval)
    there = Problem(replace(rival.experiment, runs=(run,), initial_measured=False))
    carried = Carried(there, rival.fit)
    table = np.concatenate([carried.predict(0)[0][:, :, None], carried.by(0, rival.fit.freed)], axis=2)
    here = Averaging(known.rows * interval / spacing, interval) if interval > spacing else known
    whiteners = [Whitener(n.averaged(here, known), there.data[0].time) for n in assessment.noise]
    together = np.concatenate([whiten(table[:, i]) for i, whiten in enumerate(whiteners)])
    return together[:, 0], orthonormal(together[:, 1:])

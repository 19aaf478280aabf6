"""The gates that an equation must pass besides its score: held-out rows, and one strength in all blocks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.fit.algebra import orthonormal
from warmlink.orchestration.diagnosis.fit.fitted import Carried
from warmlink.orchestration.diagnosis.fit.fitting import by_number
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.wandering import Wander
from warmlink.orchestration.diagnosis.ladder.prediction import (
    HeldOut,
    Predicted,
    Scores,
    verdict_after_holdout,
)
from warmlink.orchestration.diagnosis.terms.missing import Missing
from warmlink.orchestration.diagnosis.terms.modelled import Modelled, with_equation

_BLOCKS = 5
"""Blocks of time in which a term may have a strength of its own."""

_UNSTABLE = 1e-4
"""Chance level of strengths that differ so much between blocks, below which a term is not the same in all."""


@dataclass(frozen=True)
class Foretold:
    """What a model with terms says of the whole experiment, and its held-out errors, if rows are held out."""

    predicted: Predicted
    held_out: HeldOut | None


def foretold(model: Modelled, experiment: Experiment, scores: Scores, wander: Wander) -> Foretold:
    """Predict the whole experiment by a model with terms, and judge it by the scores' noise."""
    whole = Problem(with_equation(experiment, model.chosen))
    carried = Carried(whole, model.fit)
    readings = tuple(whole.finest(run, z) for run, z in enumerate(carried.values))
    predicted = Predicted(carried, readings)
    return Foretold(predicted, scores.held_out(predicted, wander))


def with_other_levels(model: Modelled, signals: Sequence[Mapping[str, Array]]) -> Iterator[Modelled]:
    """A model, then the same with its switches at other levels that the fitted rows do not tell from them.

    A switch is known to lie between two levels of the fitted rows; held-out rows may have levels between.
    """
    yield model
    for number, candidate in enumerate(model.chosen.candidates):
        for i, shape in enumerate(candidate.form.shapes):
            if shape.fitted:
                continue
            seen = [each[shape.of] for each in signals if shape.of in each]
            every = np.unique(np.round(np.concatenate([np.zeros(0), *seen]), 6))
            low, high = shape.between(candidate.shape[i])
            inside = every[(every > low) & (every < high)]
            for level in (np.append(inside, high) + np.append(low, inside)) / 2 if inside.size else ():
                values = (*candidate.shape[:i], float(level), *candidate.shape[i + 1 :])
                others = list(model.chosen.candidates)
                others[number] = replace(candidate, shape=values)
                yield replace(model, chosen=replace(model.chosen, candidates=tuple(others)))


def refused_by_held_out(before: HeldOut | None, after: HeldOut | None) -> str:
    """Why held-out rows do not bear an equation out; empty if they do, or there are none."""
    word, why = verdict_after_holdout("named", before, [after])
    return "" if word == "named" else why


def unstable(model: Modelled, missing: Missing) -> str:
    """Say which term's strength differs between blocks of time by more than chance; empty if none does."""
    from scipy.special import chdtrc

    every = list(enumerate(model.fitter.whitened(model.fit.freed, model.fit.theta)))
    residual = np.concatenate([joined[:, 0] for _, joined in every])
    numbers = [by_number(j[:, 1:], model.fit.freed, run, model.fit.freed) for run, j in every]
    known = orthonormal(np.concatenate(numbers))
    count = len(model.chosen.candidates)
    for number in range(1, count + 1):
        candidate, _ = model.of(number)
        columns = np.column_stack(
            [missing.answered(candidate.place, each) for each in _in_blocks(model, missing, number)]
        )
        free = orthonormal(columns - known @ (known.T @ columns), 1e-3)
        gain = float(np.sum((free.T @ residual) ** 2))
        if free.shape[1] and float(chdtrc(free.shape[1], gain)) * count < _UNSTABLE:
            return f"the strength of '{candidate.form.about}' is not the same throughout the run"
    return ""


def _in_blocks(model: Modelled, missing: Missing, number: int) -> list[list[Array]]:
    """Heat in W of a term, counted from 1, in each block of time alone, by run."""
    refitted = model.refitted()
    strength, candidate = refitted.strengths[number - 1], refitted.candidates[number - 1]
    heats = [strength * heat for heat in missing.followed.course(candidate)]
    experiment = missing.problem.experiment
    found = []
    for block in range(_BLOCKS):
        alone = []
        for run, heat in zip(experiment.runs, heats, strict=True):
            place = np.floor(_BLOCKS * run.time / (run.time[-1] * (1 + 1e-9)))
            alone.append(np.where(place == block, heat, 0.0))
        found.append(alone)
    return found

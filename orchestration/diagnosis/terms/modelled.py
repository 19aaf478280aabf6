"""Models with terms: a machine's equations with terms in them, fitted in the whole simulation."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from warmlink.fmus.heat_term.component import HeatTerm
from warmlink.orchestration.diagnosis.data.experiment import Calibration, Experiment
from warmlink.orchestration.diagnosis.fit.fitting import Fit, Fitter
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.verdict import Assessment
from warmlink.orchestration.diagnosis.terms.library import Candidate
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.machine.terms import NAMED, PLACES, PlacedTerm, with_terms

MOST_HEAT = 200.0
"""W of a term, at most, on the fitted rows."""

_DEAD = 1e-6

_MOST_KEPT = 24
"""Machines with terms that are kept."""


def places_of(rig: Rig) -> tuple[str, ...]:
    """Places of a machine that heat may enter."""
    return tuple(place for place in PLACES if into(rig, place))


def into(rig: Rig, place: str) -> str:
    """Input that takes the heat of a place; empty if the machine has none."""
    kind, variable = PLACES[place]
    parts = rig.called(kind)
    return f"{parts[0]}.{variable}" if parts else ""


def named(rig: Rig) -> dict[str, str]:
    """Full name of each variable that a form may follow, by the name that it has there."""
    found = {}
    for name, (kind, variable) in NAMED.items():
        parts = rig.called(kind)
        if parts:
            found[name] = f"{parts[0]}.{variable}"
    return found


@dataclass(frozen=True)
class Chosen:
    """Candidates together, with a start for the strength of each in W."""

    candidates: tuple[Candidate, ...]
    strengths: tuple[float, ...]
    largest: tuple[float, ...]

    @property
    def key(self) -> frozenset[tuple[str, str]]:
        """Forms and places, whatever the numbers."""
        return frozenset(each.key for each in self.candidates)

    def without_each(self) -> list[Chosen]:
        """The others without each of the candidates."""
        kept = [[i for i in range(len(self.candidates)) if i != k] for k in range(len(self.candidates))]
        return [
            Chosen(
                tuple(self.candidates[i] for i in some),
                tuple(self.strengths[i] for i in some),
                tuple(self.largest[i] for i in some),
            )
            for some in kept
        ]

    def terms(self, rig: Rig) -> dict[str, PlacedTerm]:
        """Terms by the name of their instance."""
        variables = named(rig)
        return {
            _instance(i): placed(rig, candidate, strength, variables, i)
            for i, (candidate, strength) in enumerate(zip(self.candidates, self.strengths, strict=True), 1)
        }

    def calibrations(self) -> tuple[Calibration, ...]:
        """Numbers of the terms that are fitted, with their bounds and starts."""
        found = []
        for i, (each, strength, size) in enumerate(
            zip(self.candidates, self.strengths, self.largest, strict=True), 1
        ):
            most = MOST_HEAT / max(size, _DEAD)
            found.append(Calibration(f"{_instance(i)}.a", -most, most, float(np.clip(strength, -most, most))))
            for shape, value in zip(each.form.shapes, each.shape, strict=True):
                if shape.fitted:
                    low, high = shape.bounds(value)
                    found.append(Calibration(f"{_instance(i)}.{shape.name}", low, high, value))
        return tuple(found)


def _instance(number: int) -> str:
    return f"term{number}"


def placed(
    rig: Rig, candidate: Candidate, strength: float, variables: Mapping[str, str], number: int
) -> PlacedTerm:
    """A candidate as a term of a machine."""
    form = candidate.form
    units = {"speed": "rad/s", "torque": "N.m"}
    shape = zip(form.shapes, candidate.shape, strict=True)
    values = {"a": (strength, "W"), **{each.name: (value, each.unit) for each, value in shape}}
    names = form.law.variables
    parameters = {name: value for name, value in {**candidate.fixed, **values}.items() if name in names}
    followed = form.variables
    term = HeatTerm(f"Term{number}", form.heat, {name: units.get(name, "K") for name in followed}, parameters)
    return PlacedTerm(term, into(rig, candidate.place), {name: variables[name] for name in followed})


class TermProblem(Problem):
    """A problem with terms in the machine; what a problem without them found out holds for it as well.

    That is what leaps and scatter of the inputs do to the readings, and the grid's error.
    """

    def __init__(self, experiment: Experiment, like: Problem) -> None:
        super().__init__(experiment)
        self.leaping, self.scattered = like.leaping, like.scattered
        self._corrections = like._corrections


@lru_cache(maxsize=_MOST_KEPT)
def _extended(rig: Rig, chosen: Chosen) -> Rig:
    """A machine with terms: the same one again, so that its equations are compiled once."""
    return with_terms(rig, chosen.terms(rig))


def with_equation(experiment: Experiment, chosen: Chosen) -> Experiment:
    """An experiment whose machine has terms, fitted beside what the user calibrates, and no cause."""
    return replace(
        experiment,
        rig=_extended(experiment.rig, chosen),
        calibrated=(*experiment.calibrated, *chosen.calibrations()),
        declared=(),
        with_shipped=False,
    )


@dataclass(frozen=True)
class Modelled:
    """A model with terms, fitted in the whole simulation."""

    chosen: Chosen
    problem: TermProblem
    fitter: Fitter
    fit: Fit

    @cached_property
    def values(self) -> dict[str, tuple[float, float]]:
        """Value and standard deviation in SI of each number of the terms, by full name."""
        deviations = np.sqrt(np.maximum(np.diag(self.fit.covariance()), 0.0)).tolist()
        numbers = zip(self.fit.freed, self.fit.theta.tolist(), deviations, strict=True)
        return {
            freed.variable: (value, deviation)
            for freed, value, deviation in numbers
            if freed.variable.startswith("term")
        }

    @property
    def numbers(self) -> int:
        """Numbers of its terms."""
        return sum(each.numbers for each in self.chosen.candidates)

    @property
    def on_bound(self) -> bool:
        """Whether a number of a term rests on its bound."""
        every = zip(self.fit.freed, self.fit.theta.tolist(), strict=True)
        return any(f.on_bound(value) for f, value in every if f.variable.startswith("term"))

    def of(self, number: int) -> tuple[Candidate, dict[str, tuple[float, float]]]:
        """A candidate, counted from 1, and its fitted numbers by name."""
        before = f"{_instance(number)}."
        own = {name.removeprefix(before): v for name, v in self.values.items() if name.startswith(before)}
        return self.chosen.candidates[number - 1], own

    def refitted(self) -> Chosen:
        """The candidates with the values that were fitted."""
        shapes, strengths = [], []
        for i in range(1, len(self.chosen.candidates) + 1):
            each, own = self.of(i)
            held = zip(each.form.shapes, each.shape, strict=True)
            shape = tuple(own[s.name][0] if s.name in own else value for s, value in held)
            shapes.append(replace(each, shape=shape))
            strengths.append(own["a"][0])
        return replace(self.chosen, candidates=tuple(shapes), strengths=tuple(strengths))


def fitted(assessment: Assessment, chosen: Chosen, like: Modelled | None = None) -> Modelled:
    """Fit terms in the whole simulation, under the noise that the search found.

    Parameters
    ----------
    assessment : the search for causes
    chosen : terms, with a start for each number
    like : a model that says nearly the same: the grid's error, and what leaps do, are taken from it
    """
    experiment = with_equation(assessment.problem.experiment, chosen)
    if like is not None:
        problem, fitter = TermProblem(experiment, like.problem), copy(like.fitter)
        fitter.problem = problem
        return Modelled(chosen, problem, fitter, fitter.fit(()))
    problem, old = TermProblem(experiment, assessment.problem), assessment.fitter
    problem.refine(problem.values_by_run(problem.calibrated, [f.start for f in problem.calibrated]))
    fitter = Fitter(problem, old.noise, old.wander, old.responses)
    return Modelled(chosen, problem, fitter, fitter.fit(()))

"""From what no cause explains to an equation: missing heat, the search, the gates, and what is believed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from warmlink.orchestration.diagnosis.causes.catalogue import with_twins
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.fit.search import NEAR
from warmlink.orchestration.diagnosis.fit.verdict import Assessment, Word
from warmlink.orchestration.diagnosis.ladder.prediction import HeldOut, Scores
from warmlink.orchestration.diagnosis.terms.gates import (
    Foretold,
    foretold,
    refused_by_held_out,
    unstable,
    with_other_levels,
)
from warmlink.orchestration.diagnosis.terms.linear import LinearFit, without_idle_numbers
from warmlink.orchestration.diagnosis.terms.missing import Missing, PlaceHeat
from warmlink.orchestration.diagnosis.terms.modelled import Modelled
from warmlink.orchestration.diagnosis.terms.search import FittedTerms, TermSearch, is_near
from warmlink.orchestration.progress import Progress, unseen

Finding = Literal["equation", "ambiguous", "catalogue", "none"]
"""One equation; a set that the data cannot tell apart; a cause of the catalogue; none earns its place."""

_LOOP = (
    "FMUs of this machine are simulated in a loop, so that what its readings answer to heat at each place "
    "and moment would take some hundred runs, and each candidate an FMU of its own; write the term that you "
    "suspect as [term.NAME] into the experiment, and calibrate its numbers"
)
"""Why nothing is looked for in a machine whose equations are hidden in FMUs."""

_NO_TERM = "none of the candidates explains the run to within the noise"
_NO_GAIN = "surroundings that wander explain the run, so that no term is worth its description"

_BY_CAUSES = "the catalogue explains the run"
_BEATEN = "causes leave less of the fitted rows, though the held-out rows do not bear them out"

MOST_MEMBERS = 12
"""Equations of a set, at most."""


@dataclass(frozen=True)
class Discovery:
    """What was found of an equation for missing heat.

    Attributes
    ----------
    finding : what is believed
    members : models of the set, that first which held-out rows bear out best; one for an equation
    tried : the best model that was tried, whatever became of it
    because : why no equation earns its place, or which cause it is
    missing : missing heat by place and run, the likeliest place first
    foretold : what each member says of the whole experiment
    causes : causes of the catalogue that together explain the run as well as the members
    thought_of : forms at places that were thought of
    bare_score : score of the model without terms; a member's is lower
    """

    finding: Finding
    members: tuple[FittedTerms, ...] = ()
    tried: FittedTerms | None = None
    because: str = ""
    missing: tuple[PlaceHeat, ...] = ()
    foretold: tuple[Foretold, ...] = ()
    causes: tuple[str, ...] = ()
    thought_of: int = 0
    bare_score: float = float("nan")

    @property
    def found(self) -> bool:
        """Whether an equation, or several, may be what is missing."""
        return self.finding in ("equation", "ambiguous")

    @property
    def extends(self) -> bool:
        """Whether the model is extended by an equation: not if causes explain the run as well."""
        return self.found and not self.causes

    @property
    def best(self) -> FittedTerms:
        """The first member."""
        return self.members[0]


def discover(
    assessment: Assessment,
    verdict: Word,
    experiment: Experiment,
    scores: Scores,
    before: HeldOut | None,
    progress: Progress = unseen,
) -> Discovery:
    """Look for an equation of the heat that a model lacks.

    Parameters
    ----------
    assessment : what the search for causes found on the fitted rows
    verdict : after the gate on held-out rows
    experiment, scores : the whole experiment, and its errors
    before : held-out errors of the model as it stands; None where no rows are held out
    """
    if experiment.rig.in_loop:
        return Discovery("none", because=_LOOP)
    if verdict == "adequate":
        return Discovery("none", because="nothing is wrong beyond the noise")
    progress("terms: missing heat", 0.0)
    missing = Missing(assessment)
    if not missing.places:
        return Discovery("none", because=f"{experiment.rig.name} has no motor and no link that takes heat")
    search = TermSearch(assessment, missing, progress)
    by_causes, causes = _catalogue_score(search, verdict)
    explaining = search.run(by_causes + NEAR)
    nothing = Discovery(
        "none",
        tried=next(iter(search.tried), None),
        missing=missing.heat(),
        thought_of=search.forms,
        bare_score=search.bare_score,
    )
    margin = by_causes - min((each.score for each in explaining), default=np.inf)
    if margin < -NEAR and np.isfinite(by_causes):
        return replace(nothing, finding="catalogue", because=_BY_CAUSES)
    if not explaining:
        return replace(nothing, because=_NO_GAIN if search.needs_none else _NO_TERM)
    explaining = _not_beaten(explaining, assessment)
    if not explaining:
        if verdict in ("named", "ambiguous"):
            return replace(nothing, finding="catalogue", because=_BY_CAUSES)
        return replace(nothing, because=_BEATEN)
    wander = assessment.fitter.wander
    passed, why = _through_the_gates(
        _best_of(explaining, missing),
        missing,
        before,
        experiment,
        lambda model: foretold(model, experiment, scores, wander),
    )
    if not passed:
        return replace(nothing, because=why[:1].lower() + why[1:].removesuffix("."))
    return _beside_causes(nothing, passed, assessment, verdict, by_causes, causes)


def _beside_causes(
    nothing: Discovery,
    passed: Sequence[tuple[FittedTerms, Foretold]],
    assessment: Assessment,
    verdict: Word,
    by_causes: float,
    causes: tuple[str, ...],
) -> Discovery:
    """What is believed of equations that passed every gate, beside causes and their score."""
    members = [each for each, _ in passed]
    margin = by_causes - min(each.score for each in members)
    if margin < -NEAR:
        return replace(nothing, finding="catalogue", because=_BY_CAUSES)
    if as_well := _causes_as_well(members, assessment, verdict, margin, causes):
        # Their own forms are no other explanations.
        own = {*as_well, *causes}
        passed = [(each, said) for each, said in passed if _disguise(each) not in own]
    elif len(passed) == 1 and (cause := _disguise(members[0])):
        as_well, passed = (cause,), []
    if not passed:
        because = f"the missing heat is {with_twins(as_well)} of the catalogue"
        return replace(nothing, finding="catalogue", because=because)
    return replace(
        nothing,
        finding="equation" if len(passed) == 1 and not as_well else "ambiguous",
        members=tuple(each for each, _ in passed),
        foretold=tuple(each for _, each in passed),
        causes=as_well,
    )


def _not_beaten(explaining: Sequence[FittedTerms], assessment: Assessment) -> list[FittedTerms]:
    """Models that leave no more of the fitted rows than causes, whatever held-out rows say of these."""
    if assessment.word not in ("named", "ambiguous"):
        return list(explaining)
    least = min(fit.chi2 for fit in (assessment.best, *assessment.rivals))
    return [each for each in explaining if each.model.fit.chi2 - least < NEAR]


def _best_of(explaining: Sequence[FittedTerms], missing: Missing) -> list[FittedTerms]:
    """The best model, and those that data do not tell from it, but for those with a number that is idle."""
    best = explaining[0]
    near = [
        each
        for each in explaining
        if is_near(each.score - best.score, each.model.fit.chi2 - best.model.fit.chi2)
    ]
    linear = [LinearFit(missing, each.model.refitted().candidates) for each in near]
    return [near[i] for i in without_idle_numbers(linear)][:MOST_MEMBERS]


def _through_the_gates(
    near: Sequence[FittedTerms],
    missing: Missing,
    before: HeldOut | None,
    experiment: Experiment,
    foretelling: Callable[[Modelled], Foretold],
) -> tuple[list[tuple[FittedTerms, Foretold]], str]:
    """Models that pass the gates with what they foretell, and why the first one that does not is refused."""
    passed, why = list[tuple[FittedTerms, Foretold]](), ""
    whole = missing.followed.logged(experiment)
    for each in near:
        fault = unstable(each.model, missing)
        levels = () if fault else with_other_levels(each.model, whole)
        tried = [(replace(each, model=model), foretelling(model)) for model in levels]
        refused = [refused_by_held_out(before, said.held_out) for _, said in tried]
        borne_out = [pair for pair, against in zip(tried, refused, strict=True) if not against]
        passed += sorted(borne_out, key=_held_out)[:1]
        why = why or fault or ("" if borne_out else refused[0])
    # What the fitted rows cannot tell apart, those held out rank.
    return sorted(passed, key=_held_out), why


def _held_out(pair: tuple[FittedTerms, Foretold]) -> float:
    """Held-out error of a model that was tried, in units of the noise; 0 where no rows are held out."""
    held_out = pair[1].held_out
    return held_out.in_noise if held_out else 0.0


def _causes_as_well(
    members: Sequence[FittedTerms],
    assessment: Assessment,
    verdict: Word,
    margin: float,
    causes: tuple[str, ...],
) -> tuple[str, ...]:
    """Causes that explain the run as well as equations: by their score, or as an equation by another name."""
    if margin < NEAR:
        return causes
    found = {name for fit in (assessment.best, *assessment.rivals) for name in fit.key}
    alike = {_disguise(each) for each in members} & found
    return tuple(sorted(alike)) if verdict in ("named", "ambiguous") else ()


def _disguise(tried: FittedTerms) -> str:
    """Cause of the catalogue that a model of one term is by another name."""
    candidates = tried.model.chosen.candidates
    return candidates[0].cause if len(candidates) == 1 else ""


def _catalogue_score(search: TermSearch, verdict: Word) -> tuple[float, tuple[str, ...]]:
    """Best score of the causes that were found, their number counted, and these causes.

    Where none explains the run, the score is infinite, and the causes are those that left least.
    """
    assessment = search.assessment
    if verdict not in ("named", "ambiguous"):
        return np.inf, tuple(sorted(assessment.best.key))
    of_cause = 2 * float(np.log(max(len(assessment.search.items), 2)))

    def score(fit: Fit) -> float:
        numbers = sum(len(item.freed) for item in fit.items)
        return fit.chi2 + of_cause * len(fit.items) + search.of_number * numbers

    best = min((assessment.best, *assessment.rivals), key=score)
    return score(best), tuple(sorted(best.key))

"""Which known value, if it were wrong, would explain a run as well as a fault of an instrument does.

An instrument is blamed where the model's physics explain nothing. But the model holds numbers that a person
gave, as the resistance of a contact, which no cause frees: on one run these are asked first. Each is freed by
itself, the promising ones become candidates beside the causes, and the search decides among all of them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from warmlink.fmus.component import Parameter
from warmlink.orchestration.diagnosis.causes.catalogue import Cause
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.fit.fitted import Wrong, what_is_wrong
from warmlink.orchestration.diagnosis.fit.fitting import Fit, Fitter
from warmlink.orchestration.diagnosis.fit.neighbours import Neighbours
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.search import NEAR
from warmlink.orchestration.diagnosis.fit.verdict import Assessment, assess, fitted_part
from warmlink.orchestration.diagnosis.fit.wandering import Responses
from warmlink.orchestration.diagnosis.ladder.errors import per_si, shown
from warmlink.orchestration.machine.rig import PLACE
from warmlink.orchestration.progress import Progress, unseen

_LOWER, _UPPER = 0.1, 10.0
"""Factors on a known value between which it is sought."""

_MOST = 3
"""Values that are fitted."""

_HELPS = 0.5
"""Share of what is wrong, as chi-square beyond the noise, that a value leaves at most if it is told."""


@dataclass(frozen=True)
class Questioned:
    """An experiment whose known values were asked: what the search found, and a sentence for each value."""

    experiment: Experiment
    assessment: Assessment
    would_help: tuple[str, ...] = ()


def asked(experiment: Experiment, found: Assessment, progress: Progress = unseen) -> Questioned:
    """Ask the known values before an instrument is blamed, or nothing is, by a search on one run.

    Parameters
    ----------
    experiment : what was searched
    found : by that search
    progress : of another search, if there is one
    """
    blamed = [item for item in found.best.items if item.cause.kind != "plant"]
    doubtful = found.word == "unknown" or (found.word in ("named", "ambiguous") and blamed)
    if not doubtful or len(found.problem.fitted_runs) > 1 or experiment.rig.in_loop:
        return Questioned(experiment, found)
    causes = known_value_causes(experiment, found.problem.slots)
    if not causes or experiment.only_calibrated:
        return Questioned(experiment, found)
    fits, fitter = _freed_alone(experiment, found, causes)
    wrong = _HELPS * (found.search.null.chi2 - fitter.count)
    told = tuple(_sentence(fitter, found, fit) for fit in fits if fit.chi2 - fitter.count < wrong)
    bar = found.best.chi2 + found.search.penalty(found.best.items) + (NEAR if blamed else 0.0)
    near = {item.cause for fit in fits if fit.chi2 < bar for item in fit.items if item.cause in causes}
    if not near:
        return Questioned(experiment, found, told)
    wider = replace(experiment, declared=(*experiment.declared, *(each for each in causes if each in near)))
    again = assess(wider, progress)
    return Questioned(experiment, found, told) if again.word == "unknown" else Questioned(wider, again, told)


def known_value_causes(experiment: Experiment, freed: Sequence[str]) -> tuple[Cause, ...]:
    """A cause for each number above 0 that a person gave for the machine and that is not freed already.

    These are known values of the experiment, of its terms, and of the parts of a system of one's own.
    """
    rig, known = experiment.rig, {**experiment.known, **experiment.runs[0].known}
    given = {f"{part}.{name}" for part, values in rig.machine.nominal.items() for name in values}
    given |= {name for name in rig.parameters if rig.part_of(name) in rig.foreign} | set(known)
    causes = []
    for name in rig.parameters:
        scalar = rig.variables[name]
        value = known.get(name, scalar.start)
        is_number = isinstance(scalar.variable, Parameter) and scalar.variable.type == "Real"
        is_free = name in freed or f"{PLACE}:{name}" in freed
        if name in given and is_number and not is_free and not scalar.is_temperature and (value or 0.0) > 0:
            causes.append(_cause(name, scalar.variable.unit))
    return tuple(causes)


def _cause(name: str, unit: str) -> Cause:
    return Cause(
        f"known_value:{name}",
        f"{name} differs from the value that was given.",
        (name,),
        _LOWER,
        _UPPER,
        "as that part would look with another value",
        f"Measure {name}, or look up where its value came from.",
        shown_unit=unit,
        relative=True,
        declared=True,
    )


def _freed_alone(
    experiment: Experiment, found: Assessment, causes: Sequence[Cause]
) -> tuple[list[Fit], Fitter]:
    """The known values that promise most, each freed in the place of all instruments, best first."""
    declared = (*experiment.declared, *causes)
    problem = Problem(fitted_part(replace(experiment, declared=declared)))
    values = problem.values_by_run((), np.zeros(0))
    problem.refine(values)
    wander = found.fitter.wander
    fitter = Fitter(problem, found.noise, wander, None if wander.still else Responses(problem, values))
    physics = {i.title for i in found.best.items if i.cause.kind == "plant" and found.word != "unknown"}
    kept = tuple(item for item in problem.items if item.title in physics)
    suspects = [item for item in problem.items if item.cause in causes]
    near = Neighbours(fitter.fit(kept), suspects, ())
    singles = list(near.singles())
    promising = sorted(near.proposals(kept, singles), key=lambda each: each.chi2)[:_MOST]
    fits = [fitter.fit(each.items, each.start()) for each in promising if np.isfinite(each.chi2)]
    return sorted(fits, key=lambda each: each.chi2), fitter


def _sentence(fitter: Fitter, found: Assessment, fit: Fit) -> str:
    """Say by how much a known value would have to be off, and what it would leave where most is wrong."""
    before, left, problem = found.begun.wrong, what_is_wrong(fitter, fit), fitter.problem
    column = max(problem.experiment.columns, key=lambda each: _over(before, each.name))
    (number,) = fit.items[-1].freed
    unit = problem.experiment.rig.unit(number.variable)
    of = shown(column.unit)
    first, then = (f"{each[column.name].rmse * per_si(of):.3g} {of}" for each in (before, left))
    return (
        f"if {number.variable} were {fit.values[number]:.4g} instead of {number.start:.4g} {unit}, "
        f"{column.name} would be off by {then} rms instead of {first}"
    )


def _over(wrong: Mapping[str, Wrong], name: str) -> float:
    """Error of a column over its noise; of an input 0."""
    return wrong[name].rmse / wrong[name].noise if name in wrong else 0.0

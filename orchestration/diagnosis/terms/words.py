"""What was found of an equation, in words and as JSON; and the machine that is extended by it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.entries import json_content
from warmlink.orchestration.diagnosis.answer.extension import extended_values
from warmlink.orchestration.diagnosis.answer.ladder import ladder_lines
from warmlink.orchestration.diagnosis.answer.next_experiment import Proposed
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.fit.fitted import what_is_wrong
from warmlink.orchestration.diagnosis.ladder.delivered import Delivery
from warmlink.orchestration.diagnosis.ladder.errors import per_si, shown
from warmlink.orchestration.diagnosis.ladder.judged import EQUATION
from warmlink.orchestration.diagnosis.terms.discovery import Discovery, discover
from warmlink.orchestration.diagnosis.terms.library import Candidate
from warmlink.orchestration.diagnosis.terms.modelled import Modelled, places_of, with_equation
from warmlink.orchestration.diagnosis.terms.next_experiment import Rival, next_for
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.progress import Progress, unseen
from warmlink.orchestration.scenarios.duties.duty import Segment

_SIGMA = 1.96
MOST_ALIKE = 4
"""Equations of a set that the words list, and that widen what is foreseen."""


@dataclass(frozen=True)
class Equation:
    """A diagnosis whose ladder has what was found of an equation for missing heat."""

    diagnosis: Diagnosis
    discovery: Discovery

    @property
    def extends(self) -> bool:
        """Whether the model to use from now on, which is the extended one, is that with the equation."""
        return self.diagnosis.delivered == EQUATION

    @cached_property
    def proposed(self) -> Proposed | None:
        """The duty cycle that tells the equations of a set apart; None for a single one or none."""
        if not self.discovery.found:
            return None
        experiment, assessment = self.diagnosis.experiment, self.diagnosis.assessment
        models = [each.model for each in self.discovery.members]
        rivals = [Rival(with_equation(experiment, each.chosen), each.fit) for each in models]
        by_causes = [Rival(experiment, assessment.best)] if self.discovery.causes else []
        return next_for([*rivals[:1], *by_causes, *rivals[1:]], assessment)

    @cached_property
    def held_out(self) -> dict[str, tuple[float, float]]:
        """Held-out error in SI by channel, as the model stands and with the best equation."""
        ladder = self.diagnosis.ladder
        if not self.discovery.found or not ladder.is_judged:
            return {}
        before, after = ladder.rms(ladder.rungs[0]), ladder.rms(ladder.named(EQUATION))
        return {name: (before[name], after[name]) for name in before if name in after}

    @property
    def leads(self) -> bool:
        """Whether it is the first thing to say: it explains the run, or no cause does."""
        return self.extends or self.diagnosis.verdict in ("unknown", "empirical")

    @property
    def extended(self) -> tuple[Rig, Mapping[str, float]]:
        """The machine with the terms of the best equation to be wired in, and its values in SI."""
        model, rig = self.discovery.best.model, self.diagnosis.experiment.rig
        paths = {**rig.paths, **model.refitted().terms(rig)}
        return replace(rig, paths=paths), extended_values(model.problem, model.fit)

    def lines(self) -> list[str]:
        """What is to be said, in sentences."""
        found = self.discovery
        told = []
        if found.finding == "equation":
            told.append(f"Equation: {equation_of(found.best.model)}.")
        elif found.finding == "ambiguous":
            count = len(found.members)
            told.append(f"These data cannot tell {count + bool(found.causes)} explanations apart:")
            told += [f"  {equation_of(each.model)}" for each in found.members[:MOST_ALIKE]]
            told += [f"  and {count - MOST_ALIKE} more equations"] if count > MOST_ALIKE else []
            named = "cause" if len(found.causes) == 1 else "causes"
            told += [f"  or the {named} {' and '.join(found.causes)}"] if found.causes else []
        else:
            sought = "earns its place" if found.thought_of else "was looked for"
            told.append(f"No equation {sought}: {found.because}.")
            if found.tried is not None and found.finding == "none":
                told.append(f"The best that was tried: {equation_of(found.tried.model)}.")
        if found.missing and found.finding != "catalogue":
            told.append(f"Missing heat, if all of it enters one place: {found.missing[0].sentence}.")
        if found.causes and not self.extends:
            told.append("The model with the causes stays the one to use until they are told apart.")
        if self.proposed is not None:
            told.append(f"Next: {self.proposed.why}")
        return told


def is_due(diagnosis: Diagnosis, discover: bool | None) -> bool:
    """Whether to look for an equation: if that was asked, else where no cause is established."""
    if discover is not None:
        return discover
    rig = diagnosis.experiment.rig
    is_open = diagnosis.verdict in ("unknown", "empirical") and not diagnosis.slips
    return is_open and not rig.in_loop and bool(places_of(rig))


def searched(diagnosis: Diagnosis, progress: Progress = unseen) -> Discovery:
    """What a search for the heat that a diagnosed model lacks comes to."""
    return discover(
        diagnosis.assessment,
        diagnosis.verdict,
        diagnosis.experiment,
        diagnosis.scores,
        diagnosis.held_out[0],
        progress,
    )


def discovered(diagnosis: Diagnosis, progress: Progress = unseen) -> Equation:
    """What is found of the heat that a diagnosed model lacks, and the experiment to make next.

    The diagnosis of what is returned has the equations on its ladder.
    """
    found = searched(diagnosis, progress)
    if found.found:
        equations = tuple(each.predicted for each in found.foretold[:MOST_ALIKE])
        delivery, best = Delivery(diagnosis.judged, equations, not found.causes), found.best.model
        left = what_is_wrong(best.fitter, best.fit) if delivery.by_equation else diagnosis.remaining
        diagnosis = diagnosis.with_delivery(delivery, left)
    equation = Equation(diagnosis, found)
    progress("terms: next experiment", 0.95)
    _ = equation.proposed
    return equation


def equation_of(model: Modelled) -> str:
    """The equations of a model, with units, values and 95 % intervals."""
    parts = []
    for number in range(1, len(model.chosen.candidates) + 1):
        candidate, values = model.of(number)
        told = []
        for name, each in _numbers(candidate, values).items():
            value = f"{name} = {each['value']:.4g} {each['unit']}".removesuffix(" 1")
            low, high = (f"{each[end]:.4g}" if end in each else "" for end in ("low95", "high95"))
            ends = f" (95 %: {low} to {high})" if each["fitted"] else f" (between {low} and {high})"
            told.append(f"{value}{ends if low else ''}")
        parts.append(f"heat into the {candidate.place} = {candidate.form.heat}, with {', '.join(told)}")
    return "; and ".join(parts)


def _numbers(candidate: Candidate, values: Mapping[str, tuple[float, float]]) -> dict[str, dict[str, Any]]:
    """Value, unit and interval of each number of a term by its name; those that are fixed last."""
    units = {"a": "W", **{each.name: each.unit for each in candidate.form.shapes}}
    found: dict[str, dict[str, Any]] = {}
    for name, (value, deviation) in values.items():
        half = _SIGMA * deviation
        ends = {"low95": value - half, "high95": value + half}
        found[name] = {"value": value, "std": deviation, **ends, "unit": units[name], "fitted": True}
    for name, (value, unit) in candidate.fixed.items():
        found[name] = {"value": value, "unit": unit, "fitted": False}
    for shape in candidate.form.shapes:
        if shape.levels:
            low, high = shape.between(found[shape.name]["value"])
            found[shape.name] |= {"low95": low, "high95": high}
    return found


def summary_with(diagnosis: Diagnosis, equation: Equation | None) -> str:
    """The diagnosis in plain words, with what was found of an equation behind the verdict."""
    lines = summary(diagnosis).splitlines()
    if equation is None:
        return "\n".join(lines)
    if not equation.extends:
        lines = [each for each in lines if not (equation.proposed and each.startswith("Next: "))]
        own = equation.lines()
        if equation.leads:
            return "\n".join([lines[0], *own, *lines[1:]])
        as_well = "; equations explain it as well" if equation.discovery.found else ""
        own = [*lines[1:2], *own, *lines[2:]] if as_well else [*lines[1:], *own]
        return "\n".join([f"{lines[0]}{as_well}", *_with_next_last(own)])
    found = "an equation explains it" if equation.discovery.finding == "equation" else "equations explain it"
    found += " as well" if equation.discovery.causes else ""
    beside = [each for each in lines[1:] if each.startswith(_BESIDE)]
    by_causes = next((each for each in lines[1:] if not each.startswith(_BESIDE)), "")
    names = f" ({' and '.join(each.title for each in diagnosis.causes)})" if diagnosis.causes else ""
    own = [*equation.lines(), *ladder_lines(diagnosis), f"By causes alone{names}: {by_causes}", *beside]
    return "\n".join([f"{lines[0]}; {found}", *_with_next_last(own)])


def _with_next_last(lines: list[str]) -> list[str]:
    return sorted(lines, key=lambda each: each.startswith("Next: "))


_BESIDE = ("Likely slip", "As it stands", "Look at the data")
"""How sentences begin that hold whatever explains the run."""


def content_with(
    diagnosis: Diagnosis, equation: Equation | None, ssv: str | None = None, ssp: str | None = None
) -> dict[str, Any]:
    """Contents of `diagnosis.json`, with the entry `equation` if one was looked for."""
    content = json_content(diagnosis, ssv, ssp)
    if equation is None:
        return content
    found = equation.discovery
    units = {name: shown(unit) for name, unit in diagnosis.units().items()}
    proposed = equation.proposed
    return {
        **content,
        "equation": {
            "finding": found.finding,
            "because": found.because or None,
            "causes": list(found.causes),
            "members": [_entry(each.model, each.score, each.chance) for each in found.members],
            "tried": None
            if found.tried is None
            else _entry(found.tried.model, found.tried.score, found.tried.chance),
            "score_without": found.bare_score if np.isfinite(found.bare_score) else None,
            "forms_thought_of": found.thought_of,
            "held_out": {
                name: {
                    "rmse_before": before * per_si(units[name]),
                    "rmse_after": after * per_si(units[name]),
                    "unit": units[name],
                }
                for name, (before, after) in equation.held_out.items()
            },
            "missing_heat": [
                {
                    **{"run": each.run, "place": each.place, "misfit": each.misfit},
                    **{"time_s": each.time.tolist(), "heat_W": each.heat.tolist()},
                    "std_W": each.deviation.tolist(),
                }
                for each in found.missing
            ],
            "next_experiment": None
            if proposed is None
            else {
                "why": proposed.why,
                "expected_separation_sigma": proposed.expected_separation_sigma,
                "expected_chance": proposed.expected_chance,
                "duty": [_segment(each) for each in proposed.duty],
            },
        },
    }


def _segment(segment: Segment) -> dict[str, Any]:
    return {
        "duration_s": segment.duration,
        "speed": segment.speed,
        "torque": segment.torque,
        "pad_temperature": None if np.isnan(segment.pad) else segment.pad,
        "ambient_temperature": segment.ambient_temperature,
    }


def _entry(model: Modelled, score: float, chance: float) -> dict[str, Any]:
    terms = []
    for number in range(1, len(model.chosen.candidates) + 1):
        candidate, values = model.of(number)
        terms.append(
            {
                "heat": candidate.form.heat,
                "into": candidate.place,
                "about": candidate.form.about,
                "cause": candidate.cause or None,
                "parameters": _numbers(candidate, values),
            }
        )
    return {"terms": terms, "score": score, "chance": chance}

"""What was found of an equation, in plain words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.ladder import ladder_lines
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.causes.catalogue import with_twins
from warmlink.orchestration.diagnosis.terms.equation import MOST_ALIKE, Equation
from warmlink.orchestration.diagnosis.terms.library import Candidate
from warmlink.orchestration.diagnosis.terms.modelled import Modelled

_SIGMA = 1.96


def sentences(equation: Equation) -> list[str]:
    """What is to be said of an equation, or of why there is none."""
    found = equation.discovery
    told = []
    if found.finding == "equation":
        told.append(f"Equation: {equation_of(found.best.model)}.")
    elif found.finding == "ambiguous":
        count = len(found.members)
        told.append(f"These data cannot tell {count + bool(found.causes)} explanations apart:")
        told += [f"  {equation_of(each.model)}" for each in found.members[:MOST_ALIKE]]
        told += [f"  and {count - MOST_ALIKE} more equations"] if count > MOST_ALIKE else []
        named = "cause" if len(found.causes) == 1 else "causes"
        told += [f"  or the {named} {with_twins(found.causes)}"] if found.causes else []
    else:
        sought = "earns its place" if found.thought_of else "was looked for"
        told.append(f"No equation {sought}: {found.because}.")
        if found.tried is not None and found.finding == "none":
            told.append(f"The best that was tried: {equation_of(found.tried.model)}.")
    if found.missing and found.finding != "catalogue":
        told.append(f"Missing heat, if all of it enters one place: {found.missing[0].sentence}.")
    if found.causes and not equation.extends:
        told.append("The model with the causes stays the one to use until they are told apart.")
    if equation.proposed is not None:
        told.append(f"Next: {equation.proposed.why}")
    return told


def equation_of(model: Modelled) -> str:
    """The equations of a model, with units, values and 95 % intervals."""
    parts = []
    for number in range(1, len(model.chosen.candidates) + 1):
        candidate, values = model.of(number)
        told = []
        for name, each in numbers_of(candidate, values).items():
            value = f"{name} = {each['value']:.4g} {each['unit']}".removesuffix(" 1")
            low, high = (f"{each[end]:.4g}" if end in each else "" for end in ("low95", "high95"))
            ends = f" (95 %: {low} to {high})" if each["fitted"] else f" (between {low} and {high})"
            told.append(f"{value}{ends if low else ''}")
        cause = f", which is {with_twins([candidate.cause])} of the catalogue" if candidate.cause else ""
        heat = f"heat into the {candidate.place} = {candidate.form.heat}"
        parts.append(f"{heat}, with {', '.join(told)}{cause}")
    return "; and ".join(parts)


def numbers_of(candidate: Candidate, values: Mapping[str, tuple[float, float]]) -> dict[str, dict[str, Any]]:
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
    if equation is None:
        return summary(diagnosis)
    lines = summary(diagnosis, not equation.discovery.missing).splitlines()
    if not equation.extends:
        lines = [each for each in lines if not (equation.proposed and each.startswith("Next: "))]
        own = sentences(equation)
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
    own = [*sentences(equation), *ladder_lines(diagnosis), f"By causes alone{names}: {by_causes}", *beside]
    return "\n".join([f"{lines[0]}; {found}", *_with_next_last(own)])


def _with_next_last(lines: list[str]) -> list[str]:
    return sorted(lines, key=lambda each: each.startswith("Next: "))


_BESIDE = ("Likely slip", "As it stands", "Look at the data")
"""How sentences begin that hold whatever explains the run."""

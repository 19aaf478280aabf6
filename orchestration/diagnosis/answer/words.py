"""A diagnosis in at most ten lines of plain words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from warmlink.fmus.arguments import argument
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.entries import (
    cause_entry,
    errors_in_noise,
    sentence_of,
    wrong_entries,
)
from warmlink.orchestration.diagnosis.answer.ladder import ladder_lines, people_write
from warmlink.orchestration.diagnosis.answer.profile import calibration, calibration_doubts, met_bounds
from warmlink.orchestration.diagnosis.answer.unknown import Hint
from warmlink.orchestration.diagnosis.fit.candidates import Item
from warmlink.orchestration.diagnosis.ladder.judged import CALIBRATED, UNCORRECTED
from warmlink.orchestration.diagnosis.ladder.prediction import Predicted, difference
from warmlink.orchestration.scenarios.scenario import DEFAULT_TOLERANCE

_MOST = 10
"""Lines of an answer."""


def summary(diagnosis: Diagnosis, hinted: bool = True) -> str:
    """Say in at most ten lines of plain words what was found; of a calibration all that was calibrated.

    Without `hinted` it says nothing of heat that may be missing, which a search for an equation tells better.
    """
    if diagnosis.experiment.only_calibrated or not diagnosis.experiment.catalogue:
        return _calibrated(diagnosis)
    lines = [f"{diagnosis.experiment.title}: {diagnosis.verdict}", *_slip_lines(diagnosis)]
    lines.append(_verdict_line(diagnosis))
    name = max(diagnosis.wrong, key=lambda each: diagnosis.wrong[each].rmse / diagnosis.wrong[each].noise)
    wrong = wrong_entries(diagnosis, diagnosis.wrong)[name]
    when, unit = f", worst {_during(wrong['when'][0])}" if wrong["when"] else "", people_write(wrong["unit"])
    lines.append(
        f"As it stands the simulation is off most in {name}: {wrong['rmse']:.3g} {unit} rms "
        f"against {wrong['noise']:.2g} {unit} of noise{_paused(diagnosis)}{when}."
    )
    lines += [f"Look at the data first: {each}" for each in diagnosis.doubts[:2]]
    lines += [*filter(None, (met_bounds(diagnosis),)), *calibration_doubts(diagnosis)]
    # Causes that are neither established nor used leave room for what the model to use foresees.
    most = 1 if diagnosis.delivered == CALIBRATED else 3
    lines += [_cause_line(diagnosis, item) for item in diagnosis.causes[:most]]
    lines += [f"Check the values that you gave: {'; '.join(diagnosis.would_help)}."] * bool(
        diagnosis.would_help
    )
    lines += ladder_lines(diagnosis)
    if diagnosis.causes:
        lines.append(f"On the machine: {diagnosis.causes[0].cause.check}")
        lines += _gain_lines(diagnosis)
    elif diagnosis.delivered != UNCORRECTED:
        lines += _claim_lines(diagnosis)
    after = [] if diagnosis.proposed is None else [f"Next: {diagnosis.proposed.why}"]
    if diagnosis.hint is not None:
        lines.append(_left_line(diagnosis))
        room = max(0, _MOST - len(lines) - len(after))  # a hint leaves it for what to do next
        lines += _hint_lines(diagnosis, diagnosis.hint)[:room] if hinted else []
    elif diagnosis.verdict == "unknown":
        lines.append(difference(diagnosis.experiment))
    return "\n".join([*lines, *after][:_MOST])


def _slip_lines(diagnosis: Diagnosis) -> list[str]:
    return [f"Likely slip: {each}." for each in diagnosis.slips[:3]]


def _calibrated(diagnosis: Diagnosis) -> str:
    without = argument("only_calibrated")
    told = (
        f"After calibration the error still exceeds the noise: leave out {without} to hear what may cause it."
    )
    if diagnosis.verdict == "adequate":
        told = "The calibrated model explains the data to within their noise."
    lines = [
        f"{diagnosis.experiment.title}: calibrated",
        *_slip_lines(diagnosis),
        diagnosis.verdict_and_reason[1] or told,
    ]
    lines += calibration_doubts(diagnosis)
    for each in calibration(diagnosis):
        text = _number(each.name, "=", asdict(each)) + ", of which the data say nothing" * each.unknown
        text += f", not told apart from {', '.join(each.alike)}" if each.alike else ""
        lines.append(text + ", at its bound" * each.at_bound)
    for word, errors in _errors(diagnosis, diagnosis.before):
        low, high = errors["rmse_before_95"]
        error = f"{errors['rmse_before']:.3g} times the noise (95 %: {low:.3g} to {high:.3g})"
        lines.append(f"Error on {word} rows: {error}.")
    name, wrong = max(wrong_entries(diagnosis, diagnosis.wrong).items(), key=lambda each: _over(each[1]))
    lines.append(f"Off most on fitted rows is {name}: {wrong['rmse']:.3g} {wrong['unit']} rms.")
    lines += ladder_lines(diagnosis)
    return "\n".join(lines)


def _over(wrong: Mapping[str, Any]) -> float:
    """Error over noise."""
    return float(wrong["rmse"] / wrong["noise"])


def _errors(diagnosis: Diagnosis, model: Predicted) -> list[tuple[str, dict[str, Any]]]:
    """Errors in units of noise on the fitted rows, and on the held-out ones where there are some."""
    fitted, held_out = (errors_in_noise(diagnosis, model, heldout) for heldout in (False, True))
    both = (("fitted", fitted), ("held-out", held_out))
    return [(word, errors) for word, errors in both if errors is not None]


def _verdict_line(diagnosis: Diagnosis) -> str:
    word, because = diagnosis.verdict_and_reason
    wander = diagnosis.assessment.fitter.wander
    if because:
        return because
    if word == "adequate":
        beside = "" if wander.still else f" and {wander}"
        told = f"Nothing is wrong beyond the noise{beside}{_paused(diagnosis)}"
        return f"{told}: the model is adequate."
    if word == "unknown":
        left = (
            "" if diagnosis.pattern is None else ": what is left of {} follows {}".format(*diagnosis.pattern)
        )
        return f"Something is wrong that no cause in the catalogue explains{left}."
    if word == "named":
        return "Found: " + " ".join(map(sentence_of, diagnosis.causes))
    sets = ["; or ".join(names[:4]) + (" ..." if len(names) > 4 else "") for names in diagnosis.ambiguous]
    return "These data cannot tell apart: " + " | ".join(sets[:3])


def _paused(diagnosis: Diagnosis) -> str:
    """What else counts as noise where a log pauses."""
    paused = any(run.pauses.size for run in diagnosis.experiment.runs)
    return " and what the machine may have done while the log paused" if paused else ""


def _cause_line(diagnosis: Diagnosis, item: Item) -> str:
    equals = "off by" if item.cause.added else "="
    entries = list(cause_entry(diagnosis, item)["parameters"].items())[:2]
    numbers = ", ".join(_number(name, equals, entry) for name, entry in entries)
    return f"{'Not established: ' * (diagnosis.verdict == 'empirical')}{item.title}: {numbers}"


def _number(name: str, equals: str, of: Mapping[str, Any]) -> str:
    """A number with its unit and interval."""
    value = f"{name} {equals} {of['value']:.4g} {people_write(of['unit'])}".removesuffix(" 1")
    return f"{value} (95 %: {of['low95']:.4g} to {of['high95']:.4g})"


def _during(phase: str) -> str:
    """A phase of a run, with the word that goes before it."""
    return phase if phase.startswith("after") else f"while {phase}"


def _gain_lines(diagnosis: Diagnosis) -> list[str]:
    """What the model to use gains: on these data, in an observer, and in other duty cycles."""
    model = diagnosis.after if diagnosis.delivered == UNCORRECTED else diagnosis.adopted
    parts = [
        f"{errors['rmse_before']:.3g} before and {errors['rmse_after']:.3g} after on {word} rows"
        + (_in_units(diagnosis) if word == "fitted" else "")
        for word, errors in _errors(diagnosis, model)
    ]
    lines = [f"Error as a multiple of the noise: {'; '.join(parts)}."]
    if diagnosis.observer is not None:
        before, after = diagnosis.observer
        first, then = (f"{1e6 * each.largest:.2g} µm" for each in (before, after))
        clear = "" if after.high95 < before.low95 or before.high95 < after.low95 else ", no clear difference"
        lines.append(
            f"With an observer the tool point is off by {first} at most; designed anew, by {then}{clear}."
        )
    return lines + _claim_lines(diagnosis)


def _claim_lines(diagnosis: Diagnosis) -> list[str]:
    """Where the model to use holds: in which other duty cycles, and what shows that it does not."""
    if not diagnosis.claims:
        return []
    doubtful = ", ".join(each.duty for each in diagnosis.claims if not each.holds)
    widest = 1e6 * max(each.widest for each in diagnosis.claims)
    most, count = f"{1e6 * DEFAULT_TOLERANCE:g} µm", len(diagnosis.claims)
    told = f"In {count} other duty cycles it foresees the growth within {widest:.2g} µm."
    if doubtful:
        told = (
            "Do not use it for other duty cycles: "
            f"what it foresees is uncertain by more than {most} in {doubtful}."
        )
    if diagnosis.delivered != UNCORRECTED and (within := diagnosis.holds_within) is not None:
        told += (
            f" Where a thermometer is off from it by more than {within:.2g} K it does not hold: under loads "
            "that the log lacks, or where something acts that nothing logs, as a hot workpiece or a draught."
        )
    return [told]


def _in_units(diagnosis: Diagnosis) -> str:
    """The same on fitted rows in the unit of the channel that was off most."""
    before, after = diagnosis.wrong, diagnosis.left
    name = max(before, key=lambda each: before[each].rmse / before[each].noise)
    entries = (wrong_entries(diagnosis, each)[name] for each in (before, after))
    first, then = (f"{each['rmse']:.3g}" for each in entries)
    unit = people_write(wrong_entries(diagnosis, before)[name]["unit"])
    return f" ({name} from {first} to {then} {unit} rms)"


def _left_line(diagnosis: Diagnosis) -> str:
    name, left = max(diagnosis.remaining.items(), key=lambda pair: pair[1].rmse / pair[1].noise)
    follows = f" It follows {left.correlates_with[0][0]}." if left.correlates_with else ""
    when = f" while {left.when[0]}" if left.when and not left.when[0].startswith("after") else ""
    return f"What the nearest causes leave stands out in {name}{when}.{follows}"


def _hint_lines(diagnosis: Diagnosis, hint: Hint) -> list[str]:
    return [
        f"A hint only: {hint.sentence}",
        *(f"To make up for what is wrong, {each.sentence}" for each in diagnosis.missing_heat[:1]),
    ]

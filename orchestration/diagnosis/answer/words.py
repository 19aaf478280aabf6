"""A diagnosis in at most ten lines of plain words."""

from __future__ import annotations

from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.entries import cause_entry, errors_in_noise, wrong_entries
from warmlink.orchestration.diagnosis.answer.prediction import difference
from warmlink.orchestration.diagnosis.answer.profile import calibration
from warmlink.orchestration.diagnosis.answer.unknown import Hint
from warmlink.orchestration.diagnosis.fit.problem import Item
from warmlink.orchestration.scenarios.scenario import DEFAULT_TOLERANCE

_PLAIN = {
    "adequate": "Nothing is wrong beyond the noise: the model is adequate.",
    "unknown": "Something is wrong that no cause in the catalogue explains.",
}


def summary(diagnosis: Diagnosis) -> str:
    """Say in at most ten lines of plain words what was found; of a calibration all that was calibrated."""
    if not diagnosis.experiment.catalogue:
        return _calibrated(diagnosis)
    lines = [f"{diagnosis.experiment.title}: {diagnosis.verdict}", _verdict_line(diagnosis)]
    name = max(diagnosis.wrong, key=lambda each: diagnosis.wrong[each].rmse / diagnosis.wrong[each].noise)
    wrong = wrong_entries(diagnosis, diagnosis.wrong)[name]
    when = f", worst {wrong['when'][0]}" if wrong["when"] else ""
    lines.append(
        f"As it stands the simulation is off most in {name}: {wrong['rmse']:.3g} {wrong['unit']} rms "
        f"against {wrong['noise']:.2g} {wrong['unit']} of noise{when}."
    )
    lines += [_cause_line(diagnosis, item) for item in diagnosis.causes[:3]]
    if diagnosis.causes:
        lines.append(f"On the machine: {diagnosis.causes[0].cause.check}")
        lines.append(_gain_line(diagnosis))
        lines += _observer_lines(diagnosis)
        lines += _claim_lines(diagnosis)
    if diagnosis.hint is not None:
        lines += _unknown_lines(diagnosis, diagnosis.hint)
    elif diagnosis.verdict == "unknown":
        lines.append(difference(diagnosis.experiment))
    if diagnosis.proposed is not None:
        lines.append(f"Next: {diagnosis.proposed.why}")
    return "\n".join(lines[:10])


def _calibrated(diagnosis: Diagnosis) -> str:
    within = diagnosis.verdict == "adequate"
    told = diagnosis.judged[1] or (
        "The calibrated model explains the data to within their noise."
        if within
        else "Calibration leaves what is no noise: leave out --calibrate-only to hear what may cause it."
    )
    values = [each.sentence for each in calibration(diagnosis)]
    lines = [f"{diagnosis.experiment.title}: calibrated", told, *values]
    for word, heldout in (("fitted", False), ("held-out", True)):
        errors = errors_in_noise(diagnosis, diagnosis.before, heldout)
        if errors is not None:
            low, high = errors["rmse_before_95"]
            error = f"{errors['rmse_before']:.3g} times the noise (95 %: {low:.3g} to {high:.3g})"
            lines.append(f"Error on {word} rows: {error}.")
    return "\n".join(lines)


def _verdict_line(diagnosis: Diagnosis) -> str:
    _, because = diagnosis.judged
    if because:
        return because
    wander = diagnosis.assessment.fitter.wander
    if diagnosis.verdict == "adequate" and not wander.still:
        return f"Nothing is wrong beyond the noise and {wander}: the model is adequate."
    if diagnosis.verdict in _PLAIN:
        return _PLAIN[diagnosis.verdict]
    if diagnosis.verdict == "named":
        return "Found: " + " ".join(item.cause.sentence for item in diagnosis.causes)
    sets = ["; or ".join(names[:4]) + (" ..." if len(names) > 4 else "") for names in diagnosis.ambiguous]
    return "These data cannot tell apart: " + " | ".join(sets[:3])


def _cause_line(diagnosis: Diagnosis, item: Item) -> str:
    entry = cause_entry(diagnosis, item)
    equals = "off by" if item.cause.added else "="
    values = [
        f"{variable} {equals} {p['value']:.4g} {p['unit']}".removesuffix(" 1")
        + f" (95 %: {p['low95']:.4g} to {p['high95']:.4g})"
        for variable, p in list(entry["parameters"].items())[:2]
    ]
    return f"{item.title}: {', '.join(values)}"


def _gain_line(diagnosis: Diagnosis) -> str:
    parts = []
    for word, heldout in (("fitted", False), ("held-out", True)):
        errors = errors_in_noise(diagnosis, diagnosis.after, heldout)
        if errors is not None:
            parts.append(f"{errors['rmse_before']:.3g} to {errors['rmse_after']:.3g} on {word} rows")
    return f"Error in units of noise: {', '.join(parts)}."


def _observer_lines(diagnosis: Diagnosis) -> list[str]:
    if diagnosis.observer is None:
        return []
    before, after = diagnosis.observer
    clear = after.high95 < before.low95 or before.high95 < after.low95
    return [
        f"With an observer the tool point is off by {1e6 * before.largest:.2g} um at most; designed anew, by "
        f"{1e6 * after.largest:.2g} um{'' if clear else ', no clear difference'}."
    ]


def _claim_lines(diagnosis: Diagnosis) -> list[str]:
    if not diagnosis.claims:
        return []
    doubtful = ", ".join(each.duty for each in diagnosis.claims if not each.holds)
    if doubtful:
        most = f"{1e6 * DEFAULT_TOLERANCE:g} um"
        return [f"Not for other duty cycles: its band is wider than {most} in {doubtful}."]
    widest = max(each.widest for each in diagnosis.claims)
    return [
        f"In {len(diagnosis.claims)} other duty cycles it foresees the growth within {1e6 * widest:.2g} um."
    ]


def _unknown_lines(diagnosis: Diagnosis, hint: Hint) -> list[str]:
    worst = sorted(diagnosis.remaining.items(), key=lambda pair: -pair[1].rmse / pair[1].noise)[0]
    name, left = worst
    follows = f" It follows {left.correlates_with[0][0]}." if left.correlates_with else ""
    when = f" while {left.when[0]}" if left.when and not left.when[0].startswith("after") else ""
    return [
        f"What the nearest causes leave stands out in {name}{when}.{follows}",
        f"A hint only: {hint.sentence}",
        *(f"To make up for what is wrong, {each.sentence}" for each in diagnosis.missing_heat[:1]),
    ]

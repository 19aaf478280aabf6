"""A diagnosis in words and in the entries of `diagnosis.json`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from warmlink.orchestration.diagnosis.problem import Freed, Item
from warmlink.orchestration.system.units import Unit, conversion

if TYPE_CHECKING:
    from warmlink.orchestration.diagnosis.diagnose import Diagnosis

SHOWN = {"K": 1.0, "um": 1e6, "mm": 1e3, "m": 1.0}
"""Units in which errors are shown, as multiples of SI."""

_INTERVAL = 1.959964
"""Standard deviations on either side of a 95 % interval."""

_PLAIN = {
    "adequate": "Nothing is wrong beyond the noise: the model is adequate.",
    "unknown": "Something is wrong that no cause in the catalogue explains.",
}


def shown(unit: str) -> str:
    """Unit in which an error in a column of this unit is shown: a difference of temperatures is K."""
    if unit in ("um", "µm", "micrometer", "micron"):
        return "um"
    return unit if unit in ("mm", "m") else "K"


def cause_entry(diagnosis: Diagnosis, item: Item) -> dict[str, Any]:
    """Entry of `causes`: values in the units that people read, with what speaks for it."""
    assessment = diagnosis.assessment
    fit = assessment.best
    deviations = dict(zip(fit.freed, np.sqrt(np.diag(fit.covariance())), strict=True))
    values = dict(zip(fit.freed, fit.theta, strict=True))
    parameters = {}
    for freed in item.freed:
        for variable in sorted({assessment.problem.slots[i] for i in freed.slots}):
            name = f"{variable} ({item.label} = {freed.group})" if freed.group else variable
            parameters[name] = _interval(freed, item, values[freed], float(deviations[freed]))
    from scipy.special import chdtrc

    gain = diagnosis.strength(item)
    count = assessment.fitter.count
    alone = assessment.search.fits.get(frozenset({item.title}))
    effect = None
    if item.cause.relative:
        first, nominal = item.freed[0], item.freed[0].start
        spread = _INTERVAL * float(deviations[first])
        effect = {
            "factor": values[first] / nominal,
            "low95": (values[first] - spread) / nominal,
            "high95": (values[first] + spread) / nominal,
        }
    return {
        "name": item.title,
        "parameters": parameters,
        "evidence": {
            "sentence": item.cause.sentence,
            "looks_like": item.cause.looks_like,
            "check": item.cause.check,
            "chi2_gain": gain,
            "chi2_needed": assessment.search.penalty([item]),
            "p_value": float(chdtrc(len(item.freed), gain)),
            "bic_gain": gain - len(item.freed) * float(np.log(max(count, 2))),
            "chi2_gain_alone": None if alone is None else assessment.null.chi2 - alone.chi2,
            "effect": effect,
        },
    }


def _interval(freed: Freed, item: Item, value: float, deviation: float) -> dict[str, Any]:
    unit = item.cause.shown_unit or ("m" if "camera" in freed.variable else "K")
    factor = _per_shown(freed, unit)
    return {
        "value": value * factor,
        "std": deviation * factor,
        "low95": max(value - _INTERVAL * deviation, freed.lower) * factor,
        "high95": min(value + _INTERVAL * deviation, freed.upper) * factor,
        "unit": unit,
    }


def _per_shown(freed: Freed, unit: str) -> float:
    """Factor from SI to the shown unit; all of these are differences or have no offset."""
    base = {"K/h": "K/s", "um/h": "m/s"}.get(unit, unit)
    return conversion(Unit(base), Unit(unit), difference=True)(1.0)


def summary_lines(diagnosis: Diagnosis) -> list[str]:
    """At most ten lines in plain words."""
    lines = [f"{diagnosis.experiment.title}: {diagnosis.verdict}", _verdict_line(diagnosis)]
    worst = sorted(diagnosis.wrong.items(), key=lambda pair: -pair[1].rmse / pair[1].noise)
    name, wrong = worst[0]
    unit = shown(diagnosis.units()[name])
    factor = SHOWN[unit]
    when = f", worst {wrong.when[0]}" if wrong.when else ""
    lines.append(
        f"As it stands the simulation is off most in {name}: {wrong.rmse * factor:.3g} {unit} rms "
        f"against {wrong.noise * factor:.2g} {unit} of noise{when}."
    )
    lines += [_cause_line(diagnosis, item) for item in diagnosis.causes[:3]]
    if diagnosis.causes:
        lines.append(f"On the machine: {diagnosis.causes[0].cause.check}")
        lines.append(_gain_line(diagnosis))
        lines += _observer_lines(diagnosis)
    if diagnosis.proposed is not None:
        lines.append(f"Next: {diagnosis.proposed.why}")
    if diagnosis.verdict == "unknown":
        lines += _unknown_lines(diagnosis)
    return lines[:10]


def _verdict_line(diagnosis: Diagnosis) -> str:
    if diagnosis.verdict in _PLAIN:
        return _PLAIN[diagnosis.verdict]
    if diagnosis.verdict == "named":
        return "Found: " + " ".join(item.cause.sentence for item in diagnosis.causes)
    sets = ["; or ".join(names[:4]) + (" ..." if len(names) > 4 else "") for names in diagnosis.ambiguous]
    return "These data cannot tell apart: " + " | ".join(sets[:3])


def _cause_line(diagnosis: Diagnosis, item: Item) -> str:
    entry = cause_entry(diagnosis, item)
    values = [
        f"{variable} = {p['value']:.4g} {p['unit']} (95 %: {p['low95']:.4g} to {p['high95']:.4g})".replace(
            " 1 (", " ("
        )
        for variable, p in list(entry["parameters"].items())[:2]
    ]
    return f"{item.title}: {', '.join(values)}"


def _gain_line(diagnosis: Diagnosis) -> str:
    parts = []
    for word, heldout in (("fitted", False), ("held-out", True)):
        first, then = (diagnosis.scores.rmse(p, heldout) for p in (diagnosis.before, diagnosis.after))
        if first is not None and then is not None:
            parts.append(f"{first[0]:.3g} to {then[0]:.3g} on {word} rows")
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


def _unknown_lines(diagnosis: Diagnosis) -> list[str]:
    worst = sorted(diagnosis.remaining.items(), key=lambda pair: -pair[1].rmse / pair[1].noise)[0]
    name, left = worst
    follows = f" It follows {left.correlates_with[0][0]}." if left.correlates_with else ""
    when = f" while {left.when[0]}" if left.when and not left.when[0].startswith("after") else ""
    lines = [f"What the nearest causes leave stands out in {name}{when}.{follows}"]
    if diagnosis.hint is not None:
        lines.append(f"A hint only: {diagnosis.hint.sentence}")
    return lines

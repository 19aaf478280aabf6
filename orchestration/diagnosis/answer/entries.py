"""The contents of `diagnosis.json`, with values in the units that people read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from warmlink.orchestration.diagnosis.answer.claims import Claim
from warmlink.orchestration.diagnosis.answer.compensated import Compensated
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.ladder import ladder_entries
from warmlink.orchestration.diagnosis.answer.next_experiment import Proposed
from warmlink.orchestration.diagnosis.answer.profile import INTERVAL, calibration, interval, name_of
from warmlink.orchestration.diagnosis.fit.candidates import Item
from warmlink.orchestration.diagnosis.fit.fitted import Wrong
from warmlink.orchestration.diagnosis.ladder.errors import per_si, shown
from warmlink.orchestration.diagnosis.ladder.prediction import Predicted
from warmlink.orchestration.diagnosis.model.instruments import channel_of
from warmlink.orchestration.machine.rig import OFFSET


def json_content(diagnosis: Diagnosis, ssv: str | None = None, ssp: str | None = None) -> dict[str, Any]:
    """Contents of `diagnosis.json`.

    Parameters
    ----------
    diagnosis : what was found
    ssv, ssp : names of the files of the extended model, where they are written
    """
    experiment, assessment = diagnosis.experiment, diagnosis.assessment
    wander, hint = assessment.fitter.wander, diagnosis.hint
    held_out = zip(("before", "after"), diagnosis.held_out, strict=False)
    return {
        "verdict": diagnosis.verdict,
        "causes": [cause_entry(diagnosis, item) for item in diagnosis.causes],
        "ambiguous": diagnosis.ambiguous,
        "next_experiment": None if diagnosis.proposed is None else _proposed(diagnosis.proposed),
        "calibrated": {each.name: asdict(each) for each in calibration(diagnosis)},
        "wrong": wrong_entries(diagnosis, diagnosis.wrong),
        "remaining": wrong_entries(diagnosis, diagnosis.remaining),
        "artefacts": {
            "communication_step": {
                "solved_in_one_piece": not experiment.rig.in_loop,
                "error_sigma": assessment.artefact,
            }
        },
        "prediction": {
            "because": diagnosis.verdict_and_reason[1] or None,
            **{when: None if each is None else asdict(each) for when, each in held_out},
        },
        "wandering": {
            "room_K": wander.room,
            "heat_W": wander.heat,
            "memory_s": None if wander.still else wander.memory,
        },
        "missing_heat": [
            {
                "run": each.run,
                "time_s": each.time.tolist(),
                "heat_W": each.heat.tolist(),
                "std_W": each.deviation.tolist(),
            }
            for each in diagnosis.missing_heat
        ],
        "hint": None if hint is None else {**asdict(hint), "sentence": hint.sentence},
        "slips": list(diagnosis.slips),
        "doubts": list(diagnosis.doubts),
        "known_values": list(diagnosis.would_help),
        "gain": _gain(diagnosis),
        "ladder": ladder_entries(diagnosis),
        "extended": {"ssv": ssv, "ssp": ssp},
        "claims": [_claimed(each) for each in diagnosis.claims],
        "unanswered": dict(diagnosis.unanswered),
        "remarks": list(diagnosis.remarks),
    }


def _proposed(proposed: Proposed) -> dict[str, Any]:
    duty = [
        {
            "duration_s": segment.duration,
            "speed": segment.speed,
            "torque": segment.torque,
            "pad_temperature": None if np.isnan(segment.pad) else segment.pad,
            "ambient_temperature": segment.ambient_temperature,
        }
        for segment in proposed.duty
    ]
    return {**asdict(proposed), "duty": duty, "alike": [list(pair) for pair in proposed.alike]}


def _claimed(claim: Claim) -> dict[str, Any]:
    lengths = {"largest_um": claim.largest, "change_um": claim.change, "band_um": claim.widest}
    in_um = {name: 1e6 * length for name, length in lengths.items()}
    return {"duty": claim.duty, **in_um, "holds": claim.holds}


def cause_entry(diagnosis: Diagnosis, item: Item) -> dict[str, Any]:
    """Entry of `causes`: values in the units that people read, and the evidence."""
    from scipy.special import chdtrc

    assessment = diagnosis.assessment
    search, fit = assessment.search, assessment.best
    deviations = np.sqrt(np.diag(fit.covariance())).tolist()
    found = dict(zip(fit.freed, zip(fit.theta.tolist(), deviations, strict=True), strict=True))
    parameters = {}
    for freed in item.freed:
        for variable in sorted({assessment.problem.slots[i] for i in freed.slots}):
            factor, unit = in_shown_unit(diagnosis, item, variable)
            name = name_of(item, freed, variable)
            parameters[name] = {**interval(freed, *found[freed], factor), "unit": unit}
    gain, alone = diagnosis.strength(item), search.fits.get(frozenset({item.title}))
    effect = None
    if item.cause.relative:
        value, deviation = found[item.freed[0]]
        half = INTERVAL * deviation
        ends = {"factor": value, "low95": value - half, "high95": value + half}
        effect = {name: each / item.freed[0].start for name, each in ends.items()}
    return {
        "name": item.title,
        "parameters": parameters,
        "evidence": {
            "sentence": sentence_of(item),
            "looks_like": item.cause.looks_like,
            "check": item.cause.check,
            "chi2_gain": gain,
            "chi2_needed": search.penalty([item]),
            "p_value": float(chdtrc(len(item.freed), gain)),
            "bic_gain": gain - len(item.freed) * float(np.log(max(assessment.fitter.count, 2))),
            "chi2_gain_alone": None if alone is None else assessment.search.null.chi2 - alone.chi2,
            "effect": effect,
        },
    }


def sentence_of(item: Item) -> str:
    """What happens, and with which sensor, input or part where a cause may be that of several."""
    channel = item.name.partition(":")[2]
    return f"{item.cause.sentence.removesuffix('.')} ({channel})." if channel else item.cause.sentence


def in_shown_unit(diagnosis: Diagnosis, item: Item, variable: str) -> tuple[float, str]:
    """Factor from SI to the unit in which people read a strength, and that unit.

    What is added to an input has its unit, and to a reading that of a temperature or an elongation.
    """
    rig, unit = diagnosis.experiment.rig, item.cause.shown_unit
    if not unit and variable.startswith(OFFSET):
        unit = rig.unit(variable.partition(":")[2])
    if not unit:
        channels = (channel_of(rig, output) for output in diagnosis.assessment.problem.variables)
        unit = next((each.unit for each in channels if variable == each.variable(item.cause.frees[0])), "K")
    # All shown units are of differences or have no offset.
    return per_si(unit) if unit in ("K/h", "um/h", "mm") else 1.0, unit


def wrong_entries(diagnosis: Diagnosis, wrong: Mapping[str, Wrong]) -> dict[str, dict[str, Any]]:
    """What a model gets wrong, by column name."""
    entries: dict[str, dict[str, Any]] = {}
    for name, each in wrong.items():
        unit = shown(diagnosis.units()[name])
        sizes = {size: getattr(each, size) * per_si(unit) for size in ("rmse", "noise", "bias")}
        follows = [{"signal": signal, "r": r} for signal, r in each.correlates_with]
        entries[name] = {"unit": unit, **asdict(each), **sizes, "correlates_with": follows}
    return entries


def errors_by_run(diagnosis: Diagnosis, after: Predicted) -> dict[str, dict[str, dict[str, Any]]]:
    """RMSE before and after by run and column name, in the unit that each entry names."""
    scores = diagnosis.scores
    pairs = zip(scores.by_channel(diagnosis.before), scores.by_channel(after), strict=True)
    units = {name: shown(unit) for name, unit in diagnosis.units().items()}
    return {
        run.name: {
            name: {
                "rmse_before": value * per_si(units[name]),
                "rmse_after": then[name] * per_si(units[name]),
                "unit": units[name],
            }
            for name, value in first.items()
        }
        for run, (first, then) in zip(diagnosis.experiment.runs, pairs, strict=True)
    }


def errors_in_noise(diagnosis: Diagnosis, after: Predicted, heldout: bool) -> dict[str, Any] | None:
    """RMSE before and after in units of noise, with 95 % intervals; None where there are no such rows."""
    first, then = (diagnosis.reported.rmse(each, heldout) for each in (diagnosis.before, after))
    if first is None or then is None:
        return None
    return {
        "rmse_before": first[0],
        "rmse_after": then[0],
        "rmse_before_95": list(first[1:]),
        "rmse_after_95": list(then[1:]),
    }


def _gain(diagnosis: Diagnosis) -> dict[str, Any]:
    adopted, forward, observer = diagnosis.adopted, diagnosis.feed_forward, diagnosis.observer
    heldout = errors_in_noise(diagnosis, adopted, True)
    if diagnosis.verdict == "ambiguous" and heldout is not None:
        heldout["members"] = {
            each.fit.name: {
                **(errors_in_noise(diagnosis, each, True) or {}),
                "runs": errors_by_run(diagnosis, each),
            }
            for each in (diagnosis.after, *diagnosis.members)
        }
    return {
        "fit": errors_in_noise(diagnosis, adopted, False),
        "heldout": heldout,
        "runs": errors_by_run(diagnosis, adopted),
        "compensation_um": None
        if forward is None
        else {**_in_um(*forward), "observer": None if observer is None else _in_um(*observer)},
    }


def _in_um(before: Compensated, after: Compensated) -> dict[str, Any]:
    pair = {"before": before, "after": after}
    largest = {name: 1e6 * each.largest for name, each in pair.items()}
    return largest | {f"{name}_95": [1e6 * each.low95, 1e6 * each.high95] for name, each in pair.items()}

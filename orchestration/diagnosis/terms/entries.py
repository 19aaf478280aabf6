"""What was found of an equation, as it stands in `diagnosis.json`."""

from __future__ import annotations

from typing import Any

import numpy as np

from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.entries import json_content
from warmlink.orchestration.diagnosis.ladder.errors import per_si, shown
from warmlink.orchestration.diagnosis.terms.equation import Equation
from warmlink.orchestration.diagnosis.terms.search import FittedTerms
from warmlink.orchestration.diagnosis.terms.words import numbers_of
from warmlink.orchestration.scenarios.duties.duty import Segment


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
            "members": [_entry(each) for each in found.members],
            "tried": None if found.tried is None else _entry(found.tried),
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
                    "run": each.run,
                    "place": each.place,
                    "misfit": each.misfit,
                    "time_s": each.time.tolist(),
                    "heat_W": each.heat.tolist(),
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


def _entry(fitted: FittedTerms) -> dict[str, Any]:
    terms = []
    for number in range(1, len(fitted.model.chosen.candidates) + 1):
        candidate, values = fitted.model.of(number)
        terms.append(
            {
                "heat": candidate.form.heat,
                "into": candidate.place,
                "about": candidate.form.about,
                "cause": candidate.cause or None,
                "parameters": numbers_of(candidate, values),
            }
        )
    return {"terms": terms, "score": fitted.score, "chance": fitted.chance}

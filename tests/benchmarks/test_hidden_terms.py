"""The bench of hidden terms: its laws are forms of the library, and outcomes are counted as they are."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.terms import LAWS, STRONGEST, TermTrial, _outcome, table
from warmlink.orchestration.diagnosis.practice.hidden_terms import hidden_term
from warmlink.orchestration.diagnosis.terms.library import FORMS

SPEED = ("speed to the power 1.5", "shaft")
OTHER = ("memory of speed", "shaft")


def found(finding: str, *keys: tuple[str, str], causes: tuple[str, ...] = ()) -> Any:
    members = [
        SimpleNamespace(model=SimpleNamespace(chosen=SimpleNamespace(key=frozenset({k})))) for k in keys
    ]
    known = finding in ("equation", "ambiguous")
    return SimpleNamespace(finding=finding, members=members, found=known, extends=known and not causes)


@pytest.mark.parametrize("name", LAWS)
def test_a_law_that_is_hidden_is_a_form_and_of_about_a_watt(name: str) -> None:
    law = LAWS[name]
    form = next(each for each in FORMS if each.about == law.about)
    assert law.into in form.places
    assert {each.name for each in form.shapes} == {number for number, *_ in law.numbers}
    told, values = law.drawn(np.random.default_rng(1), STRONGEST)
    term = hidden_term(told)
    assert term.parameters == pytest.approx(values)
    usual = {"speed": 3.0, "torque": 2.0, "ambient_temperature": 294.9, "shaft_temperature": 296.0}
    lags = [1.5] * term.law.lag_count
    assert 0.0 < abs(term.heat(usual, lags, 100.0)) <= 3 * STRONGEST


@pytest.mark.parametrize(
    ("finding", "verdict", "outcome"),
    [
        (found("equation", SPEED), "unknown", "right form"),
        (found("equation", OTHER), "unknown", "wrong"),
        (found("ambiguous", OTHER, SPEED), "named", "right set"),
        (found("ambiguous", OTHER), "named", "wrong set"),
        (found("catalogue"), "named", "wrong cause"),
        (found("catalogue"), "ambiguous", "catalogue set"),
        (found("none"), "unknown", "none"),
        (found("none"), "adequate", "adequate"),
    ],
)
def test_what_is_said_of_a_hidden_term_is_counted(finding: Any, verdict: str, outcome: str) -> None:
    diagnosis: Any = SimpleNamespace(verdict=verdict)
    assert _outcome("speed^1.5", finding, diagnosis) == outcome


def test_what_is_said_of_a_sound_run_is_counted() -> None:
    diagnosis: Any = SimpleNamespace(verdict="named")
    assert _outcome("nothing", found("equation", SPEED), diagnosis) == "invented"
    assert _outcome("nothing", found("ambiguous", SPEED, causes=("x",)), diagnosis) == "set with the causes"
    assert _outcome("nothing", found("none"), diagnosis) == "nothing"


def test_the_table_counts_by_kind() -> None:
    one = TermTrial("speed^1.5", 0, 1, "", "unknown", "equation", "", "right form", 1.1, 2.0)
    two = TermTrial("speed^1.5", 1, 1, "", "unknown", "none", "", "none", None, 2.0)
    (row,) = table([one, two])
    assert row == {
        **{"hidden": "speed^1.5", "runs": 2, "right form": 1, "none": 1},
        "largest held-out ratio": "1.1",
    }

"""What is believed of equations beside causes, and beside each other."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.ladder.prediction import HeldOut
from warmlink.orchestration.diagnosis.terms import discovery
from warmlink.orchestration.diagnosis.terms.discovery import (
    Discovery,
    _beside_causes,
    _catalogue_score,
    _causes_as_well,
    _not_beaten,
    _through_the_gates,
)
from warmlink.orchestration.diagnosis.terms.gates import Foretold
from warmlink.orchestration.diagnosis.terms.library import FORMS, Candidate
from warmlink.orchestration.diagnosis.terms.modelled import Chosen, Modelled
from warmlink.orchestration.diagnosis.terms.search import FittedTerms

THERMOSTAT = next(each for each in FORMS if each.about == "switched on by cold surroundings")


def test_causes_are_scored_by_what_they_leave_not_by_what_they_gain() -> None:
    """The uncorrected model's chi-square is another one in every search, and 1 % of it may be a thousand."""
    best = SimpleNamespace(chi2=2430.0, items=[SimpleNamespace(freed=("a", "b"))], key={"one"})
    rival = SimpleNamespace(chi2=2431.0, items=[SimpleNamespace(freed=("a",))], key={"other"})
    assessment = SimpleNamespace(best=best, rivals=(), search=SimpleNamespace(items=range(50)))
    search: Any = SimpleNamespace(assessment=assessment, of_number=8.0, bare_score=121661.0)
    named = 2430.0 + 2 * np.log(50) + 16.0
    assert _catalogue_score(search, "named") == (pytest.approx(named), ("one",))
    assert _catalogue_score(search, "empirical")[0] == np.inf
    # Of friction at large and Coulomb friction alone, the latter was there, and forms in disguise were said.
    assessment.rivals = (rival,)
    assert _catalogue_score(search, "ambiguous") == (pytest.approx(named - 7.0), ("other",))


def test_a_cause_by_another_name_explains_a_run_as_well_as_its_equation() -> None:
    """Heat in proportion to speed is Coulomb friction, though another fit of it was better by chance."""

    def fitted(cause: str) -> Any:
        candidates = (SimpleNamespace(cause=cause),)
        return SimpleNamespace(model=SimpleNamespace(chosen=SimpleNamespace(candidates=candidates)))

    assessment: Any = SimpleNamespace(
        best=SimpleNamespace(key={"friction_level"}), rivals=[SimpleNamespace(key={"coulomb_friction"})]
    )
    members, best = [fitted("coulomb_friction"), fitted("")], ("friction_level",)
    assert _causes_as_well(members, assessment, "ambiguous", 16.3, best) == ("coulomb_friction",)
    assert _causes_as_well(members[1:], assessment, "ambiguous", 16.3, best) == ()
    assert _causes_as_well(members, assessment, "unknown", 16.3, best) == ()
    assert _causes_as_well(members[1:], assessment, "ambiguous", 3.0, best) == best


@pytest.mark.parametrize(
    ("word", "left", "kept"), [("named", 3406.0, 0), ("named", 3099.0, 1), ("unknown", 3406.0, 1)]
)
def test_what_leaves_more_than_a_cause_is_not_believed(word: str, left: float, kept: int) -> None:
    """A clock was off, held-out rows did not bear it out, and two switches were said to make heat instead."""
    assessment: Any = SimpleNamespace(word=word, best=SimpleNamespace(chi2=3096.0), rivals=())
    model: Any = SimpleNamespace(fit=SimpleNamespace(chi2=left))
    switches = FittedTerms(model, left + 52.0, 0.08)
    assert len(_not_beaten([switches], assessment)) == kept


@pytest.mark.parametrize(
    ("score", "finding", "beside"),
    [(108.0, "catalogue", ()), (101.0, "ambiguous", ("radiation",)), (90.0, "equation", ())],
)
def test_causes_are_weighed_against_equations_that_passed(
    score: float, finding: str, beside: tuple[str, ...]
) -> None:
    """An equation that held-out rows refused was better than the cause; the one left was worse."""
    chosen = SimpleNamespace(candidates=(SimpleNamespace(cause=""),))
    model: Any = SimpleNamespace(chosen=chosen)
    passed: Any = [(FittedTerms(model, score, 1.0), None)]
    assessment: Any = SimpleNamespace(best=SimpleNamespace(key={"radiation"}), rivals=())
    found = _beside_causes(Discovery("none"), passed, assessment, "named", 100.0, ("radiation",))
    assert (found.finding, found.causes) == (finding, beside)


def test_held_out_rows_say_between_which_levels_a_switch_lies(monkeypatch: pytest.MonkeyPatch) -> None:
    """The middle of the fitted levels passed the gate, so that better ones were not looked at."""
    monkeypatch.setattr(discovery, "unstable", lambda *_: "")
    levels = replace(THERMOSTAT.shapes[0], levels=(294.0, 296.0))
    candidate = Candidate(replace(THERMOSTAT, shapes=(levels,)), "base", (295.0,))
    nothing: Any = None
    model = Modelled(Chosen((candidate,), (1.0,), (1.0,)), nothing, nothing, nothing)
    ambient = np.array([294.0, 294.6, 295.4, 296.0])
    followed = SimpleNamespace(logged=lambda _: [{"ambient_temperature": ambient}])
    missing: Any = SimpleNamespace(followed=followed)

    def foretelling(model: Modelled) -> Foretold:
        off = abs(model.chosen.candidates[0].shape[0] - 294.3)
        return Foretold(nothing, HeldOut({"elongation": 1.0}, 1.0 + off))

    before = HeldOut({"elongation": 50.0}, 50.0)
    near = [FittedTerms(model, 0.0, 1.0)]
    ((found, said),), _ = _through_the_gates(near, missing, before, nothing, foretelling)
    assert found.model.chosen.candidates[0].shape == pytest.approx((294.3,))
    assert said.held_out is not None
    assert said.held_out.in_noise == pytest.approx(1.0)

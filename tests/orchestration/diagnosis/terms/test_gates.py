"""The gates that an equation must pass: one strength in all blocks of time, and where a switch may lie."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.terms.gates import unstable, with_other_levels
from warmlink.orchestration.diagnosis.terms.library import FORMS, Candidate, Form
from warmlink.orchestration.diagnosis.terms.modelled import Chosen, Modelled
from warmlink.orchestration.diagnosis.terms.shape import ShapeNumber

TIME = 10.0 * np.arange(500)
NOISE = np.random.default_rng(3).normal(size=TIME.size)

SWITCH = ShapeNumber("b", "rad/s", of="speed", fitted=False, levels=(0.0, 1.0, 3.0))
DEAD_ZONE = replace(SWITCH, fitted=True)
STEADY = Form("constant", "a")


def model(*shapes: ShapeNumber, at: float = 2.0) -> Modelled:
    """A model with a constant heat, then one that depends on numbers of a shape."""
    form = Form("only above a speed", "a * step(speed - b)", shapes=shapes)
    candidates = Candidate(STEADY, "shaft", ()), Candidate(form, "shaft", (at,) * len(shapes))
    unasked: Any = None
    return Modelled(Chosen(candidates, (1.0, 1.0), (5.0, 5.0)), unasked, unasked, unasked)


def levels(of: Modelled, *speeds: list[float]) -> list[float]:
    """Values of the switch that are offered for runs of these speeds, the model's own first."""
    offered = [*with_other_levels(of, [{"speed": np.array(each)} for each in speeds])]
    assert offered[0] is of
    assert all(each.chosen.candidates[0] is of.chosen.candidates[0] for each in offered)
    return [each.chosen.candidates[1].shape[0] for each in offered]


def test_it_is_tried_between_the_levels_that_lie_inside() -> None:
    assert levels(model(SWITCH), [0.0, 1.0, 3.0], [2.5, 1.5, 1.5]) == pytest.approx([2.0, 1.25, 2.0, 2.75])


def test_where_no_other_level_lies_inside_the_model_stays() -> None:
    assert levels(model(SWITCH), [0.0, 1.0, 3.0, 0.5, 4.0]) == [2.0]


def test_what_is_fitted_is_no_switch() -> None:
    assert levels(model(DEAD_ZONE), [0.0, 1.0, 1.5, 3.0]) == [2.0]


def test_runs_in_which_nobody_logged_the_signal_say_nothing() -> None:
    offered = with_other_levels(model(SWITCH), [{"torque": np.array([1.5])}])
    assert len([*offered]) == 1


def said(left: Array) -> str:
    """What is said of a constant heat that the readings answer to at once, by what its model leaves."""
    form = next(each for each in FORMS if each.about == "constant")
    number = SimpleNamespace(variable="term1.a", runs=(0,), calibrated=True, slots=(0,))
    fit: Any = SimpleNamespace(freed=[number], theta=np.array([2.0]), covariance=lambda: np.eye(1))
    joined = np.column_stack([left, np.ones(TIME.size)])
    fitter: Any = SimpleNamespace(whitened=lambda freed, theta: [joined])
    problem: Any = SimpleNamespace(experiment=SimpleNamespace(runs=[SimpleNamespace(time=TIME)]))
    missing: Any = SimpleNamespace(
        followed=SimpleNamespace(course=lambda candidate: [np.ones(TIME.size)]),
        problem=problem,
        answered=lambda place, courses: np.concatenate(courses),
    )
    chosen = Chosen((Candidate(form, "shaft", ()),), (1.0,), (1.0,))
    return unstable(Modelled(chosen, problem, fitter, fit), missing)


def test_a_strength_that_differs_between_halves_of_a_run_is_refused() -> None:
    drift = np.where(np.arange(TIME.size) < TIME.size // 2, 0.3, -0.3)
    assert said(NOISE + drift) == "the strength of 'constant' is not the same throughout the run"


def test_noise_makes_no_strength_unstable() -> None:
    assert said(NOISE) == ""

"""The gate of one strength in all blocks of time."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.terms.gates import unstable
from warmlink.orchestration.diagnosis.terms.library import FORMS, Candidate
from warmlink.orchestration.diagnosis.terms.modelled import Chosen, Modelled

TIME = 10.0 * np.arange(500)
NOISE = np.random.default_rng(3).normal(size=TIME.size)


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

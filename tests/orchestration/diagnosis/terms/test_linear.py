"""Terms fitted to what readings answer to heat: the shapes' numbers reach the least squares."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.terms.library import FORMS, Candidate, candidates
from warmlink.orchestration.diagnosis.terms.linear import LinearFit, without_idle_numbers

SPEED = np.tile(np.linspace(0.0, 4.0, 41), 3)


class Answers:
    """Readings that answer to a heat above a dead zone by the heat itself."""

    def __init__(self, residual: Array) -> None:
        self.residual = residual

    def columns(self, candidates: tuple[Candidate, ...]) -> Array:
        powers = [SPEED ** (1.5 if "1.5" in each.form.about else 1.0) for each in candidates]
        zones = [np.maximum(SPEED - each.shape[0], 0.0) if each.shape else None for each in candidates]
        every = (p if z is None else z for p, z in zip(powers, zones, strict=True))
        return np.column_stack([np.zeros((SPEED.size, 0)), *every])


def candidate(about: str, *shape: float) -> Candidate:
    form = next(each for each in FORMS if each.about == about)
    return Candidate(form.at("shaft"), "shaft", shape)


def fit(residual: Array, *some: Candidate) -> LinearFit:
    answers: Any = Answers(residual)
    return LinearFit(answers, some)


def test_the_number_of_a_shape_is_fitted_with_the_strength() -> None:
    begun = fit(2.0 * np.maximum(SPEED - 1.37, 0.0), candidate("speed above a dead zone", 2.4))
    found = begun.polished()
    assert found.candidates[0].shape[0] == pytest.approx(1.37, abs=0.01)
    assert found.strengths == pytest.approx([2.0], rel=0.01)
    assert found.chi2 < 1e-3 * begun.chi2


def test_a_switch_near_the_end_of_a_signal_of_many_levels_is_found() -> None:
    """Levels ended at nine tenths of the signal, so that heat that pauses seldom had no equation."""
    room = 295.0 + np.sin(np.linspace(0.0, 40.0, 3000))
    signals = {"ambient_temperature": room}

    def columns(some: tuple[Candidate, ...]) -> Array:
        return np.column_stack([(room < each.shape[0]).astype(float) for each in some])

    answers: Any = SimpleNamespace(
        residual=3.0 * (room < 295.985), columns=columns, followed=SimpleNamespace(on_fitted_rows=signals)
    )
    every = [each for each in candidates(signals, ("base",)) if "cold surroundings" in each.form.about]
    begun = min((LinearFit(answers, (each,)) for each in every), key=lambda fit: fit.chi2)
    found = begun.polished()
    (switch,) = found.candidates[0].form.shapes
    low, high = switch.between(found.candidates[0].shape[0])
    assert low <= 295.985 <= high
    assert high - low < 0.01
    assert found.chi2 < 0.1 * begun.chi2


def test_it_stays_within_the_bounds_around_where_it_began() -> None:
    found = fit(np.maximum(SPEED - 3.5, 0.0), candidate("speed above a dead zone", 0.5)).polished()
    assert found.candidates[0].shape[0] <= 4 * 0.5


def test_no_term_leaves_all_there_is() -> None:
    left = np.random.default_rng(1).normal(size=SPEED.size)
    assert fit(left).chi2 == pytest.approx(float(left @ left))
    assert fit(left).polished().candidates == ()


def test_a_form_without_a_shape_has_nothing_to_polish() -> None:
    found = fit(3.0 * SPEED, candidate("proportional to speed")).polished()
    assert found.strengths == pytest.approx([3.0])
    assert not found.switches
    assert found.numbers == 1


def test_a_dead_zone_of_no_width_is_left_out_and_another_explanation_is_not() -> None:
    noise = np.random.default_rng(2).normal(size=SPEED.size)
    line = candidate("proportional to speed")
    idle = [fit(SPEED + noise, line), fit(SPEED + noise, candidate("speed above a dead zone", 0.02))]
    assert without_idle_numbers([each.polished() for each in idle]) == [0]
    slow = 2.0 * np.maximum(SPEED - 2.0, 0.0) + noise
    other = [fit(slow, line), fit(slow, candidate("speed above a dead zone", 1.8)).polished()]
    assert without_idle_numbers(other) == [0, 1]


def test_what_says_the_same_and_is_another_form_stays_beside_a_simpler_one() -> None:
    target = 0.2 * np.maximum(SPEED - 1.0, 0.0)
    power = fit(target, candidate("speed to the power 1.5"))
    zone = fit(target, candidate("speed above a dead zone", 1.2)).polished()
    assert np.sum((power.left - zone.left) ** 2) < 4.0
    assert without_idle_numbers([power, zone]) == [0, 1]

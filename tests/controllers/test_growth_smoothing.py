"""Three filters in a row: growth at a constant rate passes as it is, noise does not."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from warmlink.controllers.smoothing import NONE, begun, on_time, smoothed

TAU = 20.0


def followed(growth: np.ndarray, step: float = 1.0, tau: float = TAU) -> np.ndarray:
    """What is not late, of a growth sampled every step."""
    p, filters, found = SimpleNamespace(smoothing_time=tau), begun(growth[0]), []
    for value in growth[1:]:
        filters = smoothed(filters, value, p, step)
        found.append(on_time(filters))
    return np.array(found)


def test_growth_at_a_constant_rate_is_not_late() -> None:
    ramp = 1e-7 * np.arange(1000.0)
    assert followed(ramp)[-1] == pytest.approx(ramp[-1], abs=1e-7), "within one sample"


def test_a_constant_stays_what_it_is() -> None:
    assert followed(np.full(50, 3e-5)) == pytest.approx(3e-5, rel=1e-12)


def test_noise_is_a_small_part_of_what_it_was() -> None:
    noise = np.random.default_rng(1).normal(0.0, 1e-6, 4000)
    assert np.std(followed(noise)[500:]) < 0.3e-6


@pytest.mark.parametrize("step", [0.5, 10.0])
def test_the_first_filter_is_an_exponential_at_any_sample_time(step: float) -> None:
    p, filters = SimpleNamespace(smoothing_time=TAU), begun(0.0)
    for _ in range(round(60 / step)):
        filters = smoothed(filters, 1e-5, p, step)
    assert filters[0] == pytest.approx(1e-5 * -np.expm1(-60 / TAU), rel=1e-9)


def test_without_a_time_constant_nothing_is_smoothed() -> None:
    growth = np.random.default_rng(2).normal(0.0, 1e-6, 20)
    assert followed(growth, tau=NONE) == pytest.approx(growth[1:], rel=1e-12)

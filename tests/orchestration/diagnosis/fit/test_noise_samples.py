"""What of a channel's residuals is taken for noise: no loud stretch, and no course slower than 15 minutes."""

from __future__ import annotations

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.fit.noise import (
    LASTING,
    SLOW,
    NoiseModel,
    NoiseSample,
    Spectrum,
    Whitener,
    estimate,
    undisturbed,
)

STEP, STRETCH = 10.0, 60


def sample(values: np.ndarray) -> NoiseSample:
    return NoiseSample(STEP * np.arange(values.size), values, np.zeros((values.size, 0)))


def noise(count: int) -> np.ndarray:
    return np.random.default_rng(9).normal(0.0, 0.1, count)


def test_a_loud_stretch_is_left_out_and_what_is_as_it_was_beside_it_stays() -> None:
    values = noise(8 * STRETCH)
    values[3 * STRETCH : 4 * STRETCH] += 2.0
    kept = undisturbed(sample(values))
    assert [(each.times[0], each.times[-1]) for each in kept] == [
        (0.0, STEP * (3 * STRETCH - 1)),
        (STEP * 4 * STRETCH, STEP * (8 * STRETCH - 1)),
    ]


def test_a_stretch_beside_it_that_is_louder_than_noise_goes_with_it() -> None:
    values = noise(8 * STRETCH)
    values[3 * STRETCH : 4 * STRETCH] += 2.0
    values[4 * STRETCH : 5 * STRETCH] += 0.12
    alone = noise(8 * STRETCH)
    alone[6 * STRETCH : 7 * STRETCH] += 0.12
    assert undisturbed(sample(values))[1].times[0] == STEP * 5 * STRETCH
    assert len(undisturbed(sample(alone))) == 1, "by itself it is no fault"


def test_sound_noise_is_kept_whole_and_so_is_what_is_too_short_to_compare() -> None:
    assert [each.times.size for each in undisturbed(sample(noise(8 * STRETCH)))] == [8 * STRETCH]
    short = noise(4 * STRETCH)
    short[STRETCH : 2 * STRETCH] += 2.0
    assert [each.times.size for each in undisturbed(sample(short))] == [4 * STRETCH]


@pytest.mark.parametrize("count", [200, 361, 900])
def test_no_course_slower_than_a_quarter_of_an_hour_counts(count: int) -> None:
    """The mode k of n rows has the period 2 n / k rows."""
    found = Spectrum([sample(noise(count))], 1e-6)
    periods = 2 * np.pi / found.phase * STEP
    assert periods.max() <= SLOW * (1 + 1 / count)
    assert periods.max() > SLOW * 0.7, "nothing that is quicker is left out"


def test_each_part_of_the_noise_is_correlated_over_its_own_time() -> None:
    model = NoiseModel(0.3, slow=0.2, memory=50.0, lasting=0.1)
    times = np.array([0.0, 50.0, LASTING])
    found = model.covariance(times)
    assert np.diag(found) == pytest.approx([0.3**2 + 0.2**2 + 0.1**2] * 3)
    assert np.diag(found) == pytest.approx([model.sigma**2] * 3)
    near, far = (0.2**2 * np.exp(-at / 50.0) + 0.1**2 * np.exp(-at / LASTING) for at in (50.0, LASTING))
    assert found[0, 1] == found[1, 0] == pytest.approx(near)
    assert found[0, 2] == pytest.approx(far)


def test_whitened_they_are_independent_and_of_unit_size() -> None:
    model = NoiseModel(0.3, slow=0.2, memory=50.0, lasting=0.1)
    times = STEP * np.arange(40.0)
    root = np.linalg.cholesky(model.covariance(times))
    np.testing.assert_allclose(Whitener(model, times)(root), np.eye(40), atol=1e-9)


def test_noise_that_is_nearly_all_correlated_is_found_so() -> None:
    """A first-order process of 60 s and hardly anything beside it."""
    draw, kept = np.random.default_rng(3), np.exp(-STEP / 60.0)
    values = np.zeros(1000)
    for i in range(1, values.size):
        values[i] = kept * values[i - 1] + draw.normal(0.0, 0.1 * np.sqrt(1 - kept**2))
    (found,) = estimate([Spectrum([sample(values)], 1e-6)])
    assert found.slow > 4 * found.white
    assert found.sigma == pytest.approx(0.1, rel=0.25)

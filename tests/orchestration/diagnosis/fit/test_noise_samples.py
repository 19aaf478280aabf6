"""What of a channel's residuals is taken for noise: no loud stretch, and no course slower than 15 minutes."""

from __future__ import annotations

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.fit.noise import SLOW, NoiseSample, Spectrum, undisturbed

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

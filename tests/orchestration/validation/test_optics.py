"""The camera's images and their centroid."""

from dataclasses import replace

import numpy as np
import pytest

from warmlink.fmus.drift_camera.component import COMPONENT as DRIFT_CAMERA
from warmlink.fmus.errors import InputError
from warmlink.orchestration.validation.cases import Bench, Case
from warmlink.orchestration.validation.optics import (
    Camera,
    Spot,
    centroid,
    characterise,
    expose,
    measured_drift,
    noise_threshold,
)

FULL = Camera.printed()
CAMERA = FULL.window(96, 96)
SPOT = Spot(48.2 * CAMERA.cell_width, 47.6 * CAMERA.cell_height)
THRESHOLD = noise_threshold(CAMERA)


def test_image_has_the_size_and_levels_of_the_paper() -> None:
    image = expose(FULL, Spot(3e-3, 2e-3, rate=1e12), np.random.default_rng(0))
    assert image.shape == (582, 752)
    assert image.max() == 2**FULL.bits - 1
    # 0.1 of 0.7 mV: nothing is darker than the black level.
    assert image.min() == round(255 / 7)


def test_light_in_the_image_is_that_of_the_spot() -> None:
    """With gamma and black level taken out, a fine scale and a wide window: pi w^2 / 2 times the peak."""
    linear = replace(CAMERA, gamma=1.0, black_level=0.0, bits=24)
    electrons = expose(linear, SPOT) * linear.full_well / (2**24 - 1)
    area = linear.cell_width * linear.cell_height
    expected = SPOT.rate * linear.shutter * np.pi * SPOT.radius**2 / 2 / area
    assert electrons.sum() == pytest.approx(expected, rel=1e-4)


def test_centroid_is_the_first_moment_over_the_zeroth() -> None:
    image = np.full((3, 4), round(CAMERA.black))
    image[1, 1] += 30
    image[1, 2] += 10
    image[2, 1] += 10
    flat = replace(CAMERA, black_level=CAMERA.white_level * round(CAMERA.black) / 255)
    x, y = centroid(image, flat, 0.0)
    assert x == pytest.approx((1.5 * 40 + 2.5 * 10) / 50 * CAMERA.cell_width)
    assert y == pytest.approx((1.5 * 40 + 2.5 * 10) / 50 * CAMERA.cell_height)


def test_centroid_of_a_noiseless_spot_is_its_centre_within_a_hundredth_of_a_cell() -> None:
    fine = replace(CAMERA, bits=16)
    threshold = noise_threshold(fine)
    x, y = centroid(expose(fine, SPOT), fine, threshold)
    assert x == pytest.approx(SPOT.x, abs=0.01 * CAMERA.cell_width)
    assert y == pytest.approx(SPOT.y, abs=0.01 * CAMERA.cell_height)


def test_dark_noise_stays_below_the_threshold() -> None:
    dark = expose(CAMERA.window(400, 400), replace(SPOT, rate=0.0), np.random.default_rng(3))
    assert np.mean(dark - CAMERA.black > THRESHOLD) < 2e-4


def test_a_threshold_within_the_dark_noise_ruins_the_centroid() -> None:
    good = characterise(CAMERA, SPOT, THRESHOLD)
    bad = characterise(CAMERA, SPOT, THRESHOLD / 3)
    assert bad.noise > 10 * good.noise


def test_brighter_spot_is_found_better() -> None:
    noise = [characterise(CAMERA, replace(SPOT, rate=r), THRESHOLD).noise for r in (6e6, 2.4e7, 1.8e8)]
    assert noise == sorted(noise, reverse=True)
    assert noise[-1] < 0.01


def test_narrow_spot_has_the_larger_bias() -> None:
    bright = replace(SPOT, rate=1.8e8)
    wide, narrow = (characterise(CAMERA, replace(bright, radius=r), THRESHOLD).bias for r in (60e-6, 10e-6))
    assert narrow > 3 * wide


def test_noise_of_the_drift_camera_is_that_of_these_images() -> None:
    declared = {p.name: p.start for p in DRIFT_CAMERA.parameters}
    assert declared["pixel_size"] == pytest.approx(CAMERA.cell_width)
    found = characterise(CAMERA, SPOT, THRESHOLD, images=400)
    assert found.total == pytest.approx(declared["centroid_noise"], rel=0.2)
    assert found.bias < found.noise
    # The spread of 400 images is itself known to 4 %.
    again = characterise(CAMERA, SPOT, THRESHOLD, images=400, seed=2)
    assert again.noise == pytest.approx(found.noise, rel=0.15)


def test_sequence_of_images_gives_back_the_growth_of_the_link() -> None:
    """The moving case, an image every 30 s: errors are the camera's alone, a fraction of a micrometre."""
    case = Case.printed("moving")
    history = Bench().run_link(case, case.drive())
    growth = np.interp(np.arange(0.0, 3601.0, 30.0), history.time, history.elongation)
    drift = measured_drift(CAMERA, SPOT, growth, THRESHOLD, np.random.default_rng(5))
    error = (drift - growth)[1:]
    noise = characterise(CAMERA, SPOT, THRESHOLD).total * CAMERA.cell_width
    # The first image's own error is common to all; the spread about it is the noise.
    assert error.std() == pytest.approx(noise, rel=0.3)
    assert np.abs(error).max() < 6 * noise
    assert growth[-1] > 200 * noise


def test_image_without_light_is_refused() -> None:
    with pytest.raises(InputError, match="no cell is"):
        centroid(expose(CAMERA, replace(SPOT, rate=0.0)), CAMERA, THRESHOLD)


def test_same_seed_gives_the_same_figures() -> None:
    assert characterise(CAMERA, SPOT, THRESHOLD, images=20) == characterise(
        CAMERA, SPOT, THRESHOLD, images=20
    )

"""The camera's images and their centroid."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.optics import (
    Camera,
    CentroidError,
    Spot,
    centroid,
    characterise,
    drift_noise,
    electrons_at_white,
    expose,
    noise_threshold,
    tuned_spot,
)
from warmlink.fmus.drift_camera.component import COMPONENT as DRIFT_CAMERA
from warmlink.fmus.errors import InputError
from warmlink.orchestration.paper.cases import PaperCase, run_link

FULL = Camera.printed()
CAMERA = FULL.window(96, 96)
SPOT = replace(tuned_spot(CAMERA), x=48.2 * CAMERA.cell_width, y=47.6 * CAMERA.cell_height)
THRESHOLD = noise_threshold(FULL)
IMAGES = 2000


@cache
def of_spot(spot: Spot = SPOT) -> CentroidError:
    return characterise(CAMERA, spot, THRESHOLD)


@cache
def of_many() -> CentroidError:
    return drift_noise(images=IMAGES)


def test_image_has_the_size_and_levels_of_the_paper() -> None:
    image = expose(FULL, Spot(3e-3, 2e-3, rate=1e12), np.random.default_rng(0))
    assert image.shape == (582, 752)
    assert image.max() == 2**FULL.bits - 1
    # 0.1 of 0.7 mV: nothing is darker than the black level.
    assert image.min() == round(255 / 7)


def test_light_in_the_image_is_that_of_the_spot() -> None:
    """With gamma and black level taken out, a fine scale and a wide window: pi w^2 / 2 times the peak."""
    linear = replace(CAMERA, gamma=1.0, black_level=0.0, bits=24)
    electrons = expose(linear, SPOT) * linear.full_level / (2**24 - 1)
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
    threshold = noise_threshold(replace(FULL, bits=16))
    x, y = centroid(expose(fine, SPOT), fine, threshold)
    assert x == pytest.approx(SPOT.x, abs=0.01 * CAMERA.cell_width)
    assert y == pytest.approx(SPOT.y, abs=0.01 * CAMERA.cell_height)


def test_dark_noise_of_a_whole_chip_stays_below_the_threshold() -> None:
    dark = replace(SPOT, rate=0.0)
    rng = np.random.default_rng(3)
    counted = [np.sum(expose(FULL, dark, rng) - FULL.black > THRESHOLD) for _ in range(10)]
    assert sum(counted) <= 1
    # The normal law holds: at half its sigmas the threshold lets through what it should.
    lower = noise_threshold(FULL, 400.0)
    expected = 400.0
    assert np.sum(expose(FULL, dark, rng) - FULL.black > lower) == pytest.approx(expected, rel=0.3)


def test_a_wider_window_lets_no_more_noise_in() -> None:
    wide = CAMERA.window(200, 200)
    found = characterise(wide, tuned_spot(wide), THRESHOLD, images=200)
    assert found.noise == pytest.approx(of_many().noise, rel=0.15)


def test_a_threshold_within_the_dark_noise_ruins_the_centroid() -> None:
    bad = characterise(CAMERA, SPOT, THRESHOLD / 3)
    assert bad.noise > 10 * of_spot().noise


def test_brighter_spot_is_found_better() -> None:
    rates = [CAMERA.rate_for(share) for share in (0.5, 0.7, 0.9)]
    noise = [of_spot(replace(SPOT, rate=rate)).noise for rate in rates]
    assert noise == sorted(noise, reverse=True)


def test_tuned_spot_reaches_nine_tenths_of_the_range_and_saturates_nowhere() -> None:
    image = expose(CAMERA, tuned_spot(CAMERA))
    # The mean over the brightest cell lies a little below the peak between cells.
    assert 0.88 * 255 < image.max() <= 0.9 * 255
    # 0.76 of full level: the gamma curve lifts it.
    assert tuned_spot(CAMERA).rate * CAMERA.shutter == pytest.approx(0.76 * CAMERA.full_level, rel=0.01)


def test_full_level_is_less_than_a_fifth_of_the_well() -> None:
    """As the maker's data sheet puts it, for gains of 16 to 22 dB and a well of 50 000 electrons."""
    assert electrons_at_white(16.0) < 0.27 * 5e4
    assert electrons_at_white(20.0) == pytest.approx(5e4 * 71.4 / 450)
    assert electrons_at_white(20.0) < 5e4 / 5


def test_width_of_the_spot_hardly_matters_unless_it_is_a_few_cells() -> None:
    narrow, *others = (of_spot(replace(SPOT, radius=radius)) for radius in (10e-6, 40e-6, 60e-6, 100e-6))
    assert narrow.bias > 3 * max(e.bias for e in others)
    assert [e.total for e in others] == pytest.approx([0.0125] * 3, rel=0.15)


def test_noise_of_the_drift_camera_is_derived_from_these_images() -> None:
    declared = {p.name: p.start for p in DRIFT_CAMERA.parameters}
    assert declared["pixel_size"] == pytest.approx(CAMERA.cell_width)
    found = of_many()
    sampling = found.noise / np.sqrt(2 * IMAGES)
    assert declared["centroid_noise"] == pytest.approx(found.total, abs=3 * sampling)
    # The bias within the cell is of little account, so that white noise stands for both.
    assert found.bias < 0.25 * found.noise
    assert found.largest < 0.006


@pytest.mark.parametrize(("gain", "read_noise", "expected"), [(16.0, 20.0, 0.008), (22.0, 50.0, 0.017)])
def test_what_the_makers_own_ranges_leave_open(gain: float, read_noise: float, expected: float) -> None:
    chip = replace(FULL, full_level=electrons_at_white(gain), read_noise=read_noise)
    assert drift_noise(chip, images=400).total == pytest.approx(expected, rel=0.1)


def test_sequence_of_images_gives_back_the_growth_of_the_link() -> None:
    """The moving case, an image every 30 s: errors are the camera's alone, a fraction of a micrometre."""
    case = PaperCase.printed("moving")
    history = run_link(case)
    growth = np.interp(np.arange(0.0, 3601.0, 30.0), history.time, history.elongation)
    rng = np.random.default_rng(5)
    images = (expose(CAMERA, replace(SPOT, x=SPOT.x + float(each)), rng) for each in growth)
    places = np.array([centroid(image, CAMERA, THRESHOLD)[0] for image in images])
    drift = places - places[0]
    error = (drift - growth)[1:]
    noise = of_spot().total * CAMERA.cell_width
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

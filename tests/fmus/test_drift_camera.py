"""DriftCamera: when pictures are taken and read, what they show, and what goes wrong with them."""

import math
from collections.abc import Callable, Mapping

import numpy as np
import pytest
from scipy import stats

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.drift_camera.component import COMPONENT

EXACT = {"centroid_noise": 0.0}


def camera(values: Mapping[str, float]) -> Instance:
    instance = Instance(COMPONENT)
    instance.set({**EXACT, **values})
    instance.initialize()
    return instance


def watch(
    instance: Instance, seconds: int, elongation: Callable[[float], float] = lambda t: t * 1e-8
) -> dict[str, np.ndarray]:
    """Outputs after each second, the elongation being that at the second's end."""
    rows = [instance.outputs().copy()]
    for k in range(seconds):
        instance.set({"elongation": elongation(k + 1.0)})
        instance.step(float(k), 1.0)
        rows.append(instance.outputs().copy())
    return dict(zip(("drift", "valid", "age"), np.array(rows).T, strict=True))


@pytest.mark.parametrize(("speed", "interval"), [(3.43, 30), (-3.43, 30), (0.0, 120), (0.01, 120)])
def test_pictures_are_taken_at_whole_intervals(speed: float, interval: int) -> None:
    seen = watch(camera({"speed": speed}), 3600)
    at = np.flatnonzero(seen["age"] == 0)
    assert at.tolist() == list(range(0, 3601, interval)), (
        "31 and 121 pictures in an hour, the start's included"
    )
    assert seen["drift"][at] == pytest.approx(at * 1e-8, abs=1e-18)
    held = np.repeat(at * 1e-8, interval)[:3601]
    assert seen["drift"] == pytest.approx(held, abs=1e-18)
    assert seen["age"].tolist() == [k % interval for k in range(3601)]
    assert np.all(seen["valid"] == 1)


def test_the_interval_follows_the_motion() -> None:
    instance = camera({"speed": 0.0})
    watch(instance, 50)
    instance.set({"speed": 1.0})
    instance.step(50.0, 1.0)
    assert instance.get("age") == 0, "the last picture is older than 30 s when motion begins"


def test_a_picture_shows_scale_drift_and_correction() -> None:
    instance = camera({"speed": 1.0, "scale": 1.05, "drift_rate": 2e-9, "correction": 3e-6})
    seen = watch(instance, 60)
    expected = 1.05 * (60e-8 - 3e-6) + 2e-9 * 60
    assert seen["drift"][-1] == pytest.approx(expected, abs=1e-18)


def test_a_delay_shows_what_was_when_the_picture_was_taken() -> None:
    seen = watch(camera({"speed": 1.0, "delay": 4.0}), 100)
    assert seen["valid"][:4].tolist() == [0, 0, 0, 0], "nothing to read before the first delay is over"
    assert np.all(seen["valid"][4:] == 1)
    assert seen["drift"][33] == 0.0
    assert seen["drift"][34] == pytest.approx(30e-8, abs=1e-18)
    assert seen["age"][34] == 4
    assert seen["age"][63] == 33


def test_noise_is_a_share_of_a_pixel() -> None:
    instance = camera({"speed": 1.0, "moving_interval": 1.0, "centroid_noise": 0.02, "seed": 7})
    seen = watch(instance, 3000, lambda t: 0.0)["drift"][1:]
    assert stats.kstest(seen / (0.02 * 8.6e-6), "norm").pvalue > 1e-3
    assert abs(np.corrcoef(seen[1:], seen[:-1])[0, 1]) < 4 / math.sqrt(3000)
    again = camera({"speed": 1.0, "moving_interval": 1.0, "centroid_noise": 0.02, "seed": 7})
    assert np.array_equal(watch(again, 3000, lambda t: 0.0)["drift"][1:], seen)


def test_lost_pictures_keep_the_last_good_one_and_say_so() -> None:
    share = 0.3
    instance = camera({"speed": 1.0, "moving_interval": 2.0, "dropout_probability": share, "seed": 3})
    seen = watch(instance, 8000)
    valid = seen["valid"][2::2]
    assert stats.binomtest(int(np.sum(valid == 0)), len(valid), share).pvalue > 1e-3
    at = np.arange(0, 8001, 2)
    for k in at[1:]:
        if seen["valid"][k] == 0:
            assert seen["drift"][k] == seen["drift"][k - 1]
            assert seen["age"][k] == seen["age"][k - 1] + 1
        else:
            assert seen["drift"][k] == pytest.approx(k * 1e-8, abs=1e-18)
            assert seen["age"][k] == 0


def test_all_or_no_pictures_may_be_lost() -> None:
    assert np.all(watch(camera({"dropout_probability": 1.0, "speed": 1.0}), 200)["valid"] == 0)
    assert np.all(watch(camera({"dropout_probability": 0.0, "speed": 1.0}), 200)["valid"] == 1)


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        (1, [0.0, 30e-8, 60e-8, 60e-8, 60e-8]),
        (2, [0.0, 30e-8, 60e-8, 90e-8 + 5e-6, 120e-8 + 5e-6]),
        (3, [0.0, 30e-8, 60e-8, 90e-8 + 20e-9, 120e-8 + 50e-9]),
        (4, [0.0, 30e-8, 60e-8, math.nan, math.nan]),
    ],
)
def test_faults(kind: int, expected: list[float]) -> None:
    fault = {"fault_kind": kind, "fault_time": 70.0, "fault_size": 5e-6, "fault_rate": 1e-9}
    seen = watch(camera({"speed": 1.0, **fault}), 120)
    assert seen["drift"][::30] == pytest.approx(np.array(expected), abs=1e-18, nan_ok=True)
    assert np.all(seen["valid"] == 1), "a fault goes unnoticed by the camera"

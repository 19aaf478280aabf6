"""Thermometers are taken in as by a plain Kalman filter, and only where they are credible."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.controllers.estimate import Estimate, sense
from warmlink.controllers.fail_safe import Trust, at_start
from warmlink.controllers.interface import SENSED
from warmlink.controllers.matrices import symmetric, upper

COUNT, SIZE, STEP = len(SENSED), 3, 1.0
ROWS = np.random.default_rng(5).normal(size=(COUNT, SIZE))
STD = np.linspace(0.1, 0.3, COUNT)
MEAN, SPREAD = np.array([1.0, -2.0, 0.5]), np.diag([0.5, 0.2, 0.1])
READINGS = ROWS @ MEAN + 0.2


def sensed(readings: Any = READINGS, std: Any = STD, news: Any = 1.0, **trust: Any) -> tuple[Estimate, Trust]:
    """Estimate and trust after one sample of all thermometers, which were trusted unless told otherwise."""
    times = {"mean_time": 120.0, "return_time": 60.0, "sample_time": STEP}
    p = SimpleNamespace(sensor_std=np.asarray(std), gate=5.0, mean_gate=0.6, **times)
    before = at_start(np.zeros(COUNT))._replace(**trust)
    belief = Estimate(MEAN, upper(SPREAD))
    return sense(belief, before, ROWS.__getitem__, readings, np.broadcast_to(news, COUNT), p, STEP)


def by_all_at_once(used: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance by the textbook's update with several readings in one vector."""
    rows, noise = ROWS[used], np.diag(STD[used] ** 2)
    gain = SPREAD @ rows.T @ np.linalg.inv(rows @ SPREAD @ rows.T + noise)
    return MEAN + gain @ (READINGS[used] - rows @ MEAN), SPREAD - gain @ rows @ SPREAD


def same(found: Estimate, used: list[int]) -> None:
    mean, spread = by_all_at_once(used)
    np.testing.assert_allclose(found.mean, mean, rtol=1e-9)
    np.testing.assert_allclose(symmetric(found.spread, SIZE), spread, rtol=1e-9, atol=1e-12)


def test_one_after_the_other_they_tell_what_they_tell_together() -> None:
    found, trust = sensed()
    same(found, [*range(COUNT)])
    assert not np.any(trust.out)


@pytest.mark.parametrize(
    "given",
    [
        {"std": np.where(np.arange(COUNT) == 2, 0.0, STD)},
        {"news": np.where(np.arange(COUNT) == 2, 0.0, 1.0)},
        {"out": np.where(np.arange(COUNT) == 2, 1.0, 0.0)},
        {"readings": np.where(np.arange(COUNT) == 2, READINGS + 50.0, READINGS)},
    ],
    ids=["not there", "nothing new", "left out before", "beyond the gate"],
)
def test_the_estimate_goes_by_the_others(given: dict[str, Any]) -> None:
    found, _ = sensed(**given)
    same(found, [0, 1, 3, 4])


def test_only_one_that_is_used_is_left_out() -> None:
    leapt = np.where(np.arange(COUNT) == 2, READINGS + 50.0, READINGS)
    assert sensed(leapt)[1].out.tolist() == [0, 0, 1, 0, 0]
    unused = np.where(np.arange(COUNT) == 2, 0.0, STD)
    assert sensed(leapt, unused)[1].out.tolist() == [0] * COUNT


def test_noise_counts_in_what_a_reading_may_differ_by() -> None:
    """Off by two and a half of its noise, which is ten times what the estimate alone leaves open."""
    noisy = np.where(np.arange(COUNT) == 2, 20.0, STD)
    found, trust = sensed(np.where(np.arange(COUNT) == 2, READINGS + 50.0, READINGS), noisy)
    assert not np.any(trust.out)
    assert not np.array_equal(found.mean, sensed(std=np.where(np.arange(COUNT) == 2, 0.0, STD))[0].mean)

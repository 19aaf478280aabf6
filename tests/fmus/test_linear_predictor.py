"""A plain fit as a component: it follows its analytic solution, and says where it was not fitted."""

import math

import numpy as np
import pytest

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.linear_predictor.component import linear_predictor
from warmlink.fmus.linear_predictor.equations import Array, Forms, LinearForm

LASTING, STEP = 1200.0, 60.0


def made(direct: float = 0.0, order: int = 1) -> Instance:
    """A temperature that follows 2 K per rad/s in 20 minutes from 300 K, above 290 K."""
    kept = math.exp(-STEP / LASTING)
    ahead: Array = np.array([[[kept]], [[0.0]]])[:order]
    driven = np.array([[(1 - kept) * 2.0, 0.0]]) if order else np.zeros((0, 2))
    size = min(order, 1)
    form = LinearForm(
        *(STEP, ahead, driven, np.full(size, (1 - kept) * 290.0), np.full(size, 300.0), np.ones(size)),
        *(np.array([0.0, direct]), 0.5, 0.2),
    )
    model = Forms({"shaft": form}, ("speed",), (("speed", "speed"),), np.zeros(2), np.array([4.0, 16.0]))
    return Instance(linear_predictor("Fit", "a fit", model, {"shaft": "K", "speed": "rad/s"}))


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("step", [1.0, 7.0, 60.0])
def test_a_lag_is_followed_exponentially_whatever_the_samples(order: int, step: float) -> None:
    fit = made(order=order)
    fit.set({"speed": 3.0, "sample_time": min(step, 10.0)})
    fit.initialize()
    assert fit.get("shaft") == pytest.approx(300.5)
    for k in range(round(600.0 / step)):
        fit.step(k * step, step)
    at = round(600.0 / step) * step
    assert fit.get("shaft") == pytest.approx(0.5 + 296.0 + 4.0 * math.exp(-at / LASTING), abs=2e-2)


def test_a_regression_tells_at_once() -> None:
    fit = made(direct=0.25, order=0)
    fit.set({"speed": 2.0})
    fit.initialize()
    assert fit.get("shaft") == pytest.approx(1.5)


def test_outside_what_was_fitted_it_says_so_and_its_spread_grows() -> None:
    fit = made()
    fit.set({"speed": 3.0})
    fit.initialize()
    assert fit.get("outside") == 0.0
    assert fit.get("shaft_spread") == pytest.approx(0.2)
    fit.set({"speed": 8.0})
    assert fit.get("outside") == pytest.approx(1.0 + 3.0)
    assert fit.get("shaft_spread") == pytest.approx(1.0)

"""The remainder follows its analytic solution, and says where it has not learnt."""

import math

import pytest

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.remainder.component import COMPONENT
from warmlink.fmus.remainder.equations import FEATURES, LAGS


def learnt(**values: float) -> Instance:
    instance = Instance(COMPONENT)
    instance.set(
        {"time_constant[1]": 300.0, "time_constant[2]": 1200.0, "time_constant[3]": 5000.0, **values}
    )
    instance.initialize()
    return instance


def test_by_itself_it_changes_nothing() -> None:
    plain = learnt(elongation=40e-6, speed=3.0, **{"temperature[2]": 310.0})
    plain.step(0.0, 600.0)
    assert plain.get("corrected_elongation") == 40e-6
    assert plain.get("corrected_temperature[2]") == 310.0
    assert plain.get("outside") == 0.0


def test_a_constant_speed_is_followed_exponentially() -> None:
    weights = {f"temperature_weight[{LAGS + FEATURES + 1}]": 2.0, "elongation_weight[1]": 1e-6}
    learned = learnt(speed=-3.0, **{"scale[1]": 4.0}, **weights)
    learned.step(0.0, 900.0)
    warm = 2.0 * 0.75 * -math.expm1(-900 / 1200)
    assert learned.get("corrected_temperature[2]") == pytest.approx(295.15 + warm, abs=2e-3)
    grown = 1e-6 * 0.75 * -math.expm1(-900 / 300)
    assert learned.get("corrected_elongation") == pytest.approx(grown, rel=2e-3)


def test_outside_what_it_learnt_it_says_so_and_its_spread_grows() -> None:
    band = {f"largest[{i}]": 0.1 for i in range(1, LAGS + 1)} | {"temperature_error[1]": 0.2}
    learned = learnt(speed=3.0, **band)
    assert learned.get("outside") == 0.0
    assert learned.get("temperature_spread[1]") == 0.2
    learned.step(0.0, 3600.0)
    assert learned.get("outside") > 1.0
    assert learned.get("temperature_spread[1]") > 0.4

"""HeatPath: what it takes from one place it gives to the other, and the heat of its source beside it."""

import math

import numpy as np
import pytest

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.heat_path.component import COMPONENT


def path(**values: float) -> Instance:
    instance = Instance(COMPONENT)
    instance.set(values)
    instance.initialize()
    return instance


def test_by_itself_it_passes_on_what_arrives() -> None:
    instance = path(to_heat_flow=7.3, from_heat_flow=-2.1, from_temperature=330.0)
    assert instance.get("total_to_heat_flow") == 7.3
    assert instance.get("total_from_heat_flow") == -2.1


def test_a_source_grows_with_time_and_with_speed_of_either_sign() -> None:
    instance = path(heat=2.0, heat_rate=0.01, heat_per_speed=0.5, speed=-3.0)
    instance.step(0.0, 100.0)
    assert instance.get("total_to_heat_flow") == pytest.approx(2 + 0.01 * 100 + 0.5 * 3, rel=1e-14)
    assert instance.get("total_from_heat_flow") == 0.0, "it comes from outside"


def test_two_bodies_approach_each_other_as_the_readme_says() -> None:
    conductance, capacity, step = 0.8, 50.0, 0.01
    instance = path(conductance=conductance)
    first, second = 330.0, 290.0
    for k in range(3000):
        instance.set({"from_temperature": first, "to_temperature": second})
        first += step / capacity * instance.get("total_from_heat_flow")
        second += step / capacity * instance.get("total_to_heat_flow")
        assert math.isclose(first + second, 620.0, rel_tol=1e-12), k
    apart = 40.0 * np.exp(-2 * conductance * 30.0 / capacity)
    assert first - second == pytest.approx(apart, rel=1e-3)

"""The lag law's doubt: what only thermometers would show."""

import math
from collections.abc import Mapping

import pytest

from warmlink.controllers.design.plant import plant_model
from warmlink.controllers.lag.component import COMPONENT as LAG
from warmlink.fmus.component.instance import Instance

COLD = 295.15


def running(values: Mapping[str, float]) -> Instance:
    instance = Instance(LAG)
    instance.set(values)
    instance.initialize()
    return instance


def std(samples: int, values: Mapping[str, float]) -> float:
    """Standard deviation in m after so many samples of a minute."""
    instance = running(values)
    for k in range(samples):
        instance.step(60.0 * k, 60.0)
    return instance.get("correction_std")


def test_what_no_thermometer_tells_counts() -> None:
    """Heat without any duty for hours, and a hall that gets warmer: it said ready in all of that time."""

    alone = {"sample_time": 60.0, "other_heat_std": 0.0}
    assert std(0, {"sample_time": 60.0}) == std(200, alone) == 2e-6
    assert std(200, {"sample_time": 60.0}) == pytest.approx(math.hypot(2e-6, 20 * 4.21e-6), rel=1e-2)
    per_kelvin = plant_model().elongation_per_kelvin
    for room in (COLD - 5, COLD + 5):
        told = {**alone, "ambient_temperature": room}
        assert std(200, told) == pytest.approx(math.hypot(2e-6, 5 * per_kelvin), rel=1e-3)
    lost = running({**alone, "ambient_temperature": COLD + 5})
    lost.set({"ambient_temperature": math.nan})
    lost.step(0.0, 60.0)
    assert (lost.get("distrusted"), lost.get("ready")) == (1.0, 0.0)
    assert lost.get("correction_std") == pytest.approx(math.hypot(2e-6, 5 * per_kelvin), rel=1e-3)

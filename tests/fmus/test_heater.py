"""Heater: power passed through exactly, or by way of a capacity and a contact."""

import dataclasses
import math

import pytest

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.errors import InputError
from warmlink.fmus.heater.component import COMPONENT

COLD = 295.15


def heater(micro_step: float = 1.0, **values: float) -> Instance:
    instance = Instance(dataclasses.replace(COMPONENT, micro_step=micro_step))
    instance.set(values)
    instance.initialize()
    return instance


@pytest.mark.parametrize("resistance", [0.0, 0.5])
def test_without_a_capacity_power_passes_through_exactly(resistance: float) -> None:
    instance = heater(power=7.3, on=0.4, contact_resistance=resistance)
    assert instance.get("heat_flow") == 0.4 * 7.3
    assert instance.get("heater_temperature") == pytest.approx(COLD + resistance * 0.4 * 7.3, rel=1e-15)
    instance.step(0.0, 600.0)
    assert instance.get("heat_delivered") == pytest.approx(0.4 * 7.3 * 600, rel=1e-13)
    instance.set({"link_base_temperature": 320.0})
    assert instance.get("heat_flow") == 0.4 * 7.3, "whatever the link's temperature"
    instance.set({"on": 1.0})
    assert instance.get("heat_flow") == 7.3, "at once"


def test_with_a_capacity_it_is_one_lump_to_second_order() -> None:
    """Into a base held at 295.15 K: P (1 - exp(-t / RC)), and its integral."""
    errors = []
    for micro in (4.0, 2.0, 1.0):
        instance = heater(micro, power=10.0, on=1.0, heat_capacity=40.0, contact_resistance=0.5)
        assert instance.get("heat_flow") == 0.0
        instance.step(0.0, 40.0)
        errors.append(instance.get("heat_flow") - 10.0 * -math.expm1(-2.0))
    assert abs(errors[-1]) < 1e-3
    assert math.log2(errors[0] / errors[2]) / 2 == pytest.approx(2, abs=0.15)
    stored = 40.0 * (instance.get("heater_temperature") - COLD)
    assert stored + instance.get("heat_delivered") == pytest.approx(400.0, rel=1e-12)


def test_a_tiny_time_constant_is_no_trouble() -> None:
    instance = heater(power=10.0, on=1.0, heat_capacity=1e-6, contact_resistance=1e-4)
    instance.step(0.0, 5.0)
    assert instance.get("heat_flow") == pytest.approx(10.0, rel=1e-6)


@pytest.mark.parametrize("capacity", [5e-324, 1e-308, 9e-7])
def test_a_capacity_too_small_to_count_with_is_refused(capacity: float) -> None:
    with pytest.raises(
        InputError, match="J/K is too small to compute with; give 0 for none or at least 1e-06"
    ):
        heater(heat_capacity=capacity, contact_resistance=0.015625)


def test_the_capacity_may_begin_warm() -> None:
    instance = heater(heat_capacity=40.0, contact_resistance=0.5, initial_temperature=COLD + 5)
    assert instance.get("heat_flow") == pytest.approx(10.0)


def test_a_capacity_without_resistance_is_refused() -> None:
    with pytest.raises(InputError, match=r"heater\.contact_resistance: 0 K/W with a heat_capacity of 3 J/K"):
        heater(heat_capacity=3.0)


def test_more_than_all_of_the_power_is_refused() -> None:
    instance = heater()
    instance.set({"on": 1.5})
    with pytest.raises(InputError, match=r"heater\.on: 1\.5 is too high; give at most 1"):
        instance.step(0.0, 1.0)

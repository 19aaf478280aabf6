"""Sliders of the page that can be played with: from where to where, and in which steps."""

from __future__ import annotations

import math
from typing import Any

import pytest

from warmlink.fmus.component import Component, Parameter, limits
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.report.live.form import form
from warmlink.orchestration.scenarios.scenario import Scenario, changed

ROUNDING = 1e-9


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return load_scenario("windshield_wiper")


@pytest.fixture(scope="module")
def whole(scenario: Scenario) -> Component:
    return scenario.joined({})


def sliders(scenario: Scenario, whole: Component) -> dict[str, Any]:
    """Fields with a slider, by the variable's name."""
    return {name: each for name, each in form(scenario, whole)["fields"].items() if each.slider}


def ends(field: Any) -> list[float]:
    """Both ends of a slider in SI units."""
    found = [field.slider["min"], field.slider["max"]]
    shown = found if field.slider["data-powers"] is None else [math.exp(each) for each in found]
    return [(each - field.shown["data-offset"]) / field.shown["data-factor"] for each in shown]


def test_a_slider_holds_its_value_and_goes_no_farther_than_the_component_takes(
    scenario: Scenario, whole: Component
) -> None:
    """A sample time of 1.2 ms had one from 0.4 ms on, and the shortest is 1 ms."""
    short = changed(scenario, parameters={"sensors.sample_time": 0.0012})
    scalars = {each.name: each for each in whole.scalars() if isinstance(each.variable, Parameter)}
    found = sliders(short, whole)
    assert len(found) > 30
    for name, field in found.items():
        low, high = ends(field)
        value = (float(field.shown["value"]) - field.shown["data-offset"]) / field.shown["data-factor"]
        room = ROUNDING * max(abs(low), abs(high))
        assert low - room <= value <= high + room, name
        # A whole number is one in the middle too, where its ends are.
        inwards = room if scalars[name].variable.type == "Real" else 0.0
        for end in (low + inwards, high - inwards):
            assert limits.problem(scalars[name], end) is None, name


def test_a_slider_of_whole_numbers_goes_by_whole_steps(scenario: Scenario, whole: Component) -> None:
    """A seed could be dragged to 1.5, which the component refuses."""
    found = sliders(scenario, whole)
    for scalar in whole.scalars():
        if scalar.name in found and scalar.variable.type == "Integer":
            assert found[scalar.name].slider["step"] == 1, scalar.name
            assert all(each == round(each) for each in ends(found[scalar.name])), scalar.name
    assert found["sensors.seed"].slider["step"] == 1

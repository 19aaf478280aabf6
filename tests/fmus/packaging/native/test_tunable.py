"""Tunable parameters of single FMUs: native as in Python, refused where they do not fit, part of a state."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.component import Component, Parameter
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR

from .conftest import BuildNative
from .running import Native, refused
from .test_states import saving

TUNED = {"housing_conductance": 2.0, "standby_power": 5.0, "joint_resistance": 0.1}


@pytest.fixture(params=["2.0", "3.0"])
def motor(request: pytest.FixtureRequest, native_fmu: BuildNative) -> Iterator[Native]:
    native = Native(native_fmu("MotorHeatSource", request.param), MOTOR, "motor")
    native.set({"speed": 3.0, "torque": 2.0})
    native.initialize()
    yield native
    native.close()


def test_a_change_has_the_effect_that_it_has_in_python(motor: Native) -> None:
    python = Instance(MOTOR)
    python.set({"speed": 3.0, "torque": 2.0})
    python.initialize()
    for i in range(40):
        if i == 20:
            motor.set(TUNED)
            python.set(TUNED)
        motor.step(10.0 * i, 10.0)
        python.step(10.0 * i, 10.0)
        for name in MOTOR.y.names:
            assert motor.get(name) == pytest.approx(python.get(name), rel=1e-9)
    assert motor.get("standby_power") == 5.0


def test_outputs_that_depend_on_it_directly_follow_at_once(motor: Native) -> None:
    motor.step(0.0, 60.0)
    before = motor.get("heat_flow")
    motor.set({"joint_resistance": 1.0})
    assert motor.get("heat_flow") == pytest.approx(before / 2)


def test_a_value_out_of_range_changes_nothing(motor: Native) -> None:
    motor.step(0.0, 60.0)
    before = [motor.get(name) for name in MOTOR.y.names]
    sentence = refused(motor, lambda: motor.set({"standby_power": float("nan")}))
    assert sentence == "motor.standby_power: nan W is not a number; give a value"
    refused(motor, lambda: motor.set({"housing_conductance": -1.0}))
    assert motor.get("housing_conductance") == 1.0
    assert [motor.get(name) for name in MOTOR.y.names] == before
    motor.step(60.0, 1.0)


def test_a_restored_state_brings_its_parameters_back(motor: Native) -> None:
    save, restore = saving(motor)
    motor.step(0.0, 60.0)
    state = save()
    motor.step(60.0, 60.0)
    expected = [motor.get(name) for name in MOTOR.y.names]
    restore(state)
    motor.set(TUNED)
    motor.step(60.0, 60.0)
    assert [motor.get(name) for name in MOTOR.y.names] != expected
    restore(state)
    assert motor.get("standby_power") == 0.0
    motor.step(60.0, 60.0)
    assert [motor.get(name) for name in MOTOR.y.names] == expected


@pytest.mark.parametrize("component", [e.component for e in catalogue()], ids=lambda c: c.name)
def test_what_says_when_to_sample_is_fixed(component: Component) -> None:
    """Samples are counted from the start; another sample time in the run would lose the count."""
    tunable = {p.name for p in component.parameters if isinstance(p, Parameter) and p.tunable}
    assert not tunable & {clock.sample_time for clock in component.clocks}
    assert not {name for name in tunable if name.startswith("initial_")}

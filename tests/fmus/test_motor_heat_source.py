"""MotorHeatSource against the linear two-lump system, its balance of energy, and the heating pad."""

import dataclasses
import math
from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.motor_heat_source.component import COMPONENT

COLD = 295.15
SPEED, TORQUE = 3.43, 2.5
COPPER = 2.0 * (TORQUE / 1.2) ** 2
IRON = 0.15 * SPEED**2
FRICTION = (1.5 + 0.6 * SPEED) * SPEED


def running(values: Mapping[str, float], component: Component = COMPONENT) -> Instance:
    instance = Instance(component)
    instance.set(values)
    instance.initialize()
    return instance


def exact_lumps(time: float) -> np.ndarray:
    """Rises of winding and shaft above 295.15 K and heat delivered; resistance constant, base cold."""
    matrix = np.zeros((4, 4))
    matrix[0] = [-0.8 / 200, 0.8 / 200, 0, (COPPER + IRON) / 200]
    matrix[1] = [0.8 / 1500, -(0.8 + 1.0 + 1.0) / 1500, 0, FRICTION / 1500]
    matrix[2] = [0, 1.0, 0, 0]
    return expm(matrix * time)[:3, 3]


def test_two_lumps_follow_the_matrix_exponential_to_second_order() -> None:
    time, steps, errors = 960.0, [60.0, 30.0, 15.0, 7.5], []
    exact = exact_lumps(time)
    for step in steps:
        motor = running(
            {"speed": SPEED, "torque": TORQUE, "winding_temperature_coefficient": 0.0},
            dataclasses.replace(COMPONENT, micro_step=step),
        )
        motor.step(0.0, time)
        errors.append(motor.get("shaft_temperature") - COLD - exact[1])
    order = math.log(abs(errors[0] / errors[-1])) / math.log(8)
    assert order == pytest.approx(2, abs=0.15)

    motor = running({"speed": SPEED, "torque": TORQUE, "winding_temperature_coefficient": 0.0})
    motor.step(0.0, time)
    assert motor.get("winding_temperature") - COLD == pytest.approx(exact[0], rel=1e-5)
    assert motor.get("shaft_temperature") - COLD == pytest.approx(exact[1], rel=1e-5)
    assert motor.get("heat_delivered") == pytest.approx(exact[2], rel=1e-5)


def test_the_current_may_be_given_instead_of_the_torque() -> None:
    by_torque = running({"torque": 2.4})
    by_current = running({"current": 2.0})
    for motor in (by_torque, by_current):
        motor.step(0.0, 300.0)
    assert by_current.get("winding_temperature") == pytest.approx(by_torque.get("winding_temperature"))


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_heat_made_is_stored_lost_or_delivered(seed: int) -> None:
    """Power terms from their own formulas; states, inputs and parameters at random."""
    rng = np.random.default_rng(seed)
    winding, shaft = COLD + rng.uniform(-10, 60, size=2)
    ambient, base, neighbour = COLD + rng.uniform(-10, 30, size=3)
    speed, torque, pad = rng.uniform(-4, 4), rng.uniform(-3, 3), rng.uniform(0, 40)
    offset, drift, time = rng.normal(), rng.normal() * 1e-4, rng.uniform(0, 7200)
    resistance, slope, standby = rng.uniform(0, 2), rng.uniform(-0.01, 0.01), rng.uniform(0, 3)
    thinning, draught, moving = rng.uniform(0, 0.05), rng.uniform(0, 0.2), rng.uniform(0, 4)
    motor = Instance(COMPONENT)
    motor.set(
        {
            "speed": speed,
            "torque": torque,
            "pad_mode": 1,
            "pad_power": pad,
            "ambient_temperature": ambient,
            "link_base_temperature": base,
            "neighbour_temperature": neighbour,
            "neighbour_conductance": 0.3,
            "joint_resistance": resistance,
            "friction_temperature_coefficient": slope,
            "viscosity_temperature_coefficient": thinning,
            "friction_factor": 1.2,
            "standby_power": standby,
            "moving_power": moving,
            "housing_conductance_per_speed": draught,
            "ambient_offset": offset,
            "ambient_drift": drift,
        }
    )
    p = np.array([motor.get(name) for name in COMPONENT.p.names])
    u = np.array([motor.get(name) for name in COMPONENT.u.names])
    rates = COMPONENT.rates_of(np.array([winding, shaft, 0.0]), u, p, time)
    viscous = 0.6 * np.exp(-thinning * (shaft - 295.15))
    made = (
        2.0 * (1 + 0.0039 * (winding - 293.15)) * (torque / 1.2) ** 2
        + 0.15 * speed**2
        + 1.2 * (1 - slope * (shaft - 295.15)) * (1.5 + viscous * abs(speed)) * abs(speed)
        + pad
        + standby
        + moving
    )
    delivered = (shaft - base) / (1 + resistance)
    housing = (1.0 + draught * abs(speed)) * (shaft - (ambient + offset + drift * time))
    lost = housing + 0.3 * (shaft - neighbour) + delivered
    assert 200 * rates[0] + 1500 * rates[1] == pytest.approx(made - lost, abs=1e-9)
    assert rates[2] == pytest.approx(delivered, rel=1e-12)


def test_in_steady_state_all_heat_leaves_by_housing_and_joint() -> None:
    motor = running(
        {"speed": SPEED, "torque": TORQUE, "winding_temperature_coefficient": 0.0},
        dataclasses.replace(COMPONENT, micro_step=20.0),
    )
    motor.step(0.0, 20000.0)
    rise = motor.get("shaft_temperature") - COLD
    assert 2.0 * rise == pytest.approx(COPPER + IRON + FRICTION, rel=1e-9)
    assert motor.get("heat_flow") == pytest.approx(rise, rel=1e-12)


def test_what_moves_is_cooled_by_its_speed_and_heated_by_its_brake_alike_at_any_speed() -> None:
    """One lump without winding and friction: P / G (1 - exp(-G t / C)) with G by the speed, none at rest."""
    lone = {"winding_conductance": 0.0, "joint_conductance": 0.0, "friction_factor": 0.0}
    for speed in (0.0, -0.5, 4.0):
        motor = running({**lone, "speed": speed, "moving_power": 6.0, "housing_conductance_per_speed": 0.1})
        motor.step(0.0, 1200.0)
        conductance = 1.0 + 0.1 * abs(speed)
        rise = 6.0 / conductance * -math.expm1(-conductance * 1200 / 1500) if speed else 0.0
        assert motor.get("shaft_temperature") - COLD == pytest.approx(rise, rel=1e-6)


# pad ------------------------------------------------------------------------------------------------------


def test_a_pad_of_given_power_heats_one_lump() -> None:
    """With the winding cut off and the joint open, the shaft is one lump: P / G (1 - exp(-G t / C))."""
    lone = {"winding_conductance": 0.0, "joint_conductance": 0.0}
    motor = running({**lone, "pad_mode": 1, "pad_power": 20.0})
    motor.step(0.0, 1500.0)
    assert motor.get("shaft_temperature") - COLD == pytest.approx(20 * -math.expm1(-1.0), rel=1e-6)
    assert motor.get("heat_flow") == 0.0


def test_a_pad_held_at_a_temperature_is_a_stiff_lump() -> None:
    """From 1 K below its temperature on the pad is never at its limit: exponential with C / (K + G)."""
    lone = {"winding_conductance": 0.0, "joint_conductance": 0.0, "initial_shaft_temperature": 308.15}
    motor = running({**lone, "pad_mode": 2, "pad_temperature": 309.15})
    final = (20 * 309.15 + 1.0 * COLD) / 21
    motor.step(0.0, 100.0)
    expected = final + (308.15 - final) * math.exp(-21 / 1500 * 100)
    assert motor.get("shaft_temperature") == pytest.approx(expected, abs=1e-5)


def test_a_pad_gives_no_more_than_its_limit_and_never_cools() -> None:
    lone = {"winding_conductance": 0.0, "joint_conductance": 0.0, "housing_conductance": 0.0}
    cold = running({**lone, "pad_mode": 2, "pad_temperature": 350.0})
    cold.step(0.0, 10.0)
    assert cold.get("shaft_temperature") - COLD == pytest.approx(60 * 10 / 1500, rel=1e-9)
    hot = running({**lone, "pad_mode": 2, "pad_temperature": 280.0})
    hot.step(0.0, 10.0)
    assert hot.get("shaft_temperature") == COLD


@pytest.mark.parametrize("mode", [0, 1, 2])
def test_only_the_mode_in_force_heats(mode: int) -> None:
    motor = running({"pad_mode": mode, "pad_power": 7.0, "pad_temperature": COLD + 1.0})
    motor.step(0.0, 1e-3)
    heat = (motor.get("shaft_temperature") - COLD) * 1500 / 1e-3
    assert heat == pytest.approx({0: 0.0, 1: 7.0, 2: 20.0}[mode], abs=1e-3)

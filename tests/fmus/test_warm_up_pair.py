"""Motor and link together against figures found by other means."""

import numpy as np
import pytest

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.reference import Phase, integrate
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.plant import demand, plant
from warmlink.fmus.thermal_link.component import COMPONENT as LINK

# Finite elements, checked against fine finite volumes: 100 % duty, 3.43 rad/s, 2.5 N.m, 22 degC, cold start.
TIMES = np.array([600, 1800, 3600, 7200])
SHAFT = np.array([27.71, 35.78, 40.97, 43.40]) + 273.15
ELONGATION = np.array([14.07, 49.95, 75.77, 87.95]) * 1e-6

RECORD = ("motor.shaft_temperature", "link.elongation", "motor.heat_delivered", "link.heat_received")
SENSORS = [f"link.sensor_temperature[{i}]" for i in range(1, 9)]


def test_the_base_model_meets_the_independent_figures() -> None:
    found = integrate(plant(), [demand(7200, 3.43, 2.5)], RECORD, every=600.0)
    at = np.searchsorted(found.time, TIMES)
    assert found.values["motor.shaft_temperature"][at] == pytest.approx(SHAFT, abs=0.05)
    assert found.values["link.elongation"][at] == pytest.approx(ELONGATION, rel=2e-3)
    # The figures are given to 0.01 K and 0.01 um; they are met to a digit of that.
    assert found.values["motor.shaft_temperature"][at] == pytest.approx(SHAFT, abs=0.006)
    assert found.values["link.elongation"][at] == pytest.approx(ELONGATION, abs=0.01e-6)
    assert found.values["motor.heat_delivered"] == pytest.approx(found.values["link.heat_received"], rel=1e-8)


PAD = {"motor.pad_mode": 2.0, "motor.pad_temperature": 315.15, "motor.speed": 0.0, "motor.torque": 0.0}


@pytest.mark.parametrize("phase", [demand(1800, 3.43, 2.5), Phase(1800, PAD)], ids=["full duty", "pad"])
def test_forty_cells_do_as_well_as_four_hundred(phase: Phase) -> None:
    """To 0.01 K and 0.05 um."""
    temperatures = ["link.base_temperature", "link.tip_temperature", *SENSORS]
    names = ["link.elongation", "link.discretisation_error", *temperatures]
    coarse, fine = (
        integrate(plant(cells), [phase], names, every=10.0, tolerance=1e-8).values for cells in (40, 400)
    )
    for name in temperatures:
        assert coarse[name] == pytest.approx(fine[name], abs=0.01), name
    error = np.abs(coarse["link.elongation"] - fine["link.elongation"])
    assert np.all(error < 0.05e-6)
    assert np.all(error <= coarse["link.discretisation_error"] + 1e-12)


def test_instances_stepped_in_turn_come_to_the_monolithic_solution() -> None:
    """Gauss-Seidel with held inputs is of first order in the communication step."""
    exact = integrate(plant(), [demand(600, 3.43, 2.5)], RECORD, every=600.0)
    errors = []
    for step in (8.0, 4.0, 2.0):
        motor, link = Instance(MOTOR, "motor"), Instance(LINK, "link")
        motor.set({"speed": 3.43, "torque": 2.5})
        link.set({"speed": 3.43})
        for each in (motor, link):
            each.initialize()
        for k in range(round(600 / step)):
            motor.set({"link_base_temperature": link.get("base_temperature")})
            link.set({"heat_flow": motor.get("heat_flow")})
            motor.step(k * step, step)
            link.step(k * step, step)
        errors.append(link.get("elongation") - exact.values["link.elongation"][-1])
    assert abs(errors[-1]) < 0.1e-6
    assert np.log2(errors[0] / errors[1]) == pytest.approx(1, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(1, abs=0.1)


def test_a_reference_run_leaves_nothing_behind_for_the_next() -> None:
    integrate(plant(), [demand(60, 3.43, 2.5)], RECORD, every=60.0)
    idle = integrate(plant(), [Phase(60.0, {})], RECORD, every=60.0)
    assert idle.values["link.elongation"].tolist() == [0.0, 0.0]

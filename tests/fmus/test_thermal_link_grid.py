"""What the thermal link's grid costs, and where it reads between its nodes."""

import math

import numpy as np
import pytest

from tests.fmus.links import ALPHA, COLD, cells_with, fin_exact, fin_share, flat, order, steady, transient
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.thermal_link.component import COMPONENT, thermal_link
from warmlink.fmus.thermal_link.equations import positions, spacings


@pytest.mark.parametrize("time", [10.0, 60.0, 600.0, 3600.0])
def test_the_estimate_covers_what_the_grid_costs(time: float) -> None:
    inputs = {"heat_flow": 5.0, "speed": 3.43}
    coarse, fine = (transient(cells, {}, inputs, time) for cells in (40, 400))
    error = abs(coarse["elongation"] - fine["elongation"])
    assert error <= coarse["discretisation_error"]
    assert error < 0.05e-6


def test_the_integral_of_a_given_profile_is_of_third_order() -> None:
    """A rise of 10 K exp(-8 x / m) along the link, between base and tip position."""
    exact = ALPHA * 10 / 8 * (math.exp(-8 * 0.0254) - math.exp(-8 * 0.3170))
    errors = []
    for intervals in (16, 32, 64, 128):
        component = thermal_link(cells_with(intervals))
        p, u = flat(Instance(component))
        link = component.d.read(p)
        x = positions(link, spacings(link, component.x.size - 1))
        rise = COLD + 10 * np.exp(-8 * (x - x[0]))
        outputs = component.outputs_of(np.append(rise, 0.0), u, p, 0.0)
        errors.append(outputs[component.y.index["elongation"]] - exact)
    assert order(errors) == pytest.approx(3, abs=0.1)


def test_positions_at_both_ends_are_those_of_the_ends() -> None:
    instance = Instance(COMPONENT)
    instance.set({"base_position": 0.0, "tip_position": 0.3302, "initial_temperature_rise[1]": 8.0})
    instance.initialize()
    assert instance.get("base_temperature") - COLD == pytest.approx(8.0, abs=1e-9)
    for k in range(60):
        instance.step(float(k), 1.0)
    assert np.all(np.isfinite(instance.outputs()))
    assert instance.get("sensor_temperature[1]") == instance.get("base_temperature")
    assert instance.get("sensor_temperature[3]") == instance.get("tip_temperature")


def test_sensors_read_between_the_nodes_to_second_order() -> None:
    place = 0.0777
    exact = COLD + fin_share(place - 0.0254, 0.3302 - 0.0254, 7.75) * (
        fin_exact(0.0254, 0.3170, 0.3302, 7.75, 5.0)["base_temperature"] - COLD
    )
    values = {"heat_flow": 5.0, "convection_still": 7.75, "sensor_position[4]": place}
    # Where the place falls between two nodes differs from grid to grid: a bound, not a slope.
    for intervals in (16, 32, 64, 128):
        error = steady(cells_with(intervals), values)["sensor_temperature[4]"] - exact
        assert abs(error) < 30.0 / intervals**2

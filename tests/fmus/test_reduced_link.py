"""A reduced link beside ThermalLink, whose connectors it has, and beside what its matrices say."""

from dataclasses import replace

import casadi
import numpy as np
import pytest

from tests.fmus.reduced_bar import ERROR_GAIN, LENGTH, bar_link, bar_model
from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.join import join
from warmlink.fmus.component.reference import Phase, integrate
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.plant import WIRES, demand
from warmlink.fmus.thermal_link.component import thermal_link

COLD = 295.15
DUTY = {"heat_flow": 8.0, "tip_heat_flow": 1.0, "speed": 2.0, "ambient_temperature": 290.0}
CARRIED = {
    "hub_heat_capacity": 40.0,
    "hub_conductance": 0.1,
    "tip_heat_capacity": 60.0,
    "tip_conductance": 0.05,
    "absorbed_flux": 20.0,
    "ambient_offset": 2.0,
}
WHOLE = {"base_position": 0.0, "tip_position": LENGTH}


def started(component: Component, **values: float) -> Instance:
    instance = Instance(component)
    instance.set(values)
    instance.initialize()
    return instance


@pytest.mark.parametrize("carried", [{}, CARRIED], ids=["bare", "carrying"])
def test_a_bar_is_that_of_thermal_link(carried: dict[str, float]) -> None:
    names = ["elongation", "tip_temperature", "surface_heat_loss", "sensor_temperature[2]"]
    phases = [Phase(600.0, DUTY), Phase(1800.0, {"heat_flow": 0.0, "speed": 0.0})]
    reduced = integrate(bar_link(), phases, names, every=300.0, tolerance=1e-6, parameters=carried).values
    slender = integrate(
        thermal_link(40), phases, names, every=300.0, tolerance=1e-6, parameters={**WHOLE, **carried}
    ).values
    assert slender["elongation"].max() > 1e-4
    for name in names:
        rise = np.abs(slender[name] - (COLD if "temperature" in name else 0.0)).max()
        assert np.abs(reduced[name] - slender[name]).max() < 0.002 * rise, name


def test_whatever_may_be_set_acts() -> None:
    """A parameter of ThermalLink that a reduced link cannot follow is none of its own."""
    link = bar_link(4)
    sizes = {"x": link.x.size, "u": link.u.size, "p": link.p.size, "time": 1}
    x, u, p, time = (casadi.SX.sym(name, size) for name, size in sizes.items())
    settled = link.settled(p)
    found = [link.rates_of(x, u, settled, time), link.outputs_of(x, u, settled, time)]
    found.append(link.states_at_start(u, settled))
    _, acting = casadi.jacobian_sparsity(casadi.vertcat(*found), casadi.vertcat(p, u)).get_triplet()
    names = [*link.p.names, *link.u.names]
    assert [name for i, name in enumerate(names) if i not in acting] == []


def test_it_takes_the_links_place_in_the_cell() -> None:
    cell = join("Plant", {"motor": MOTOR, "link": bar_link(21)}, WIRES)
    beside = join("Plant", {"motor": MOTOR, "link": thermal_link(40)}, WIRES)
    drive = [demand(1800.0, 3.43, 2.5)]
    known = {f"link.{name}": value for name, value in WHOLE.items()}
    found = integrate(cell, drive, ["link.elongation"], every=1800.0).values["link.elongation"]
    other = integrate(beside, drive, ["link.elongation"], every=1800.0, parameters=known)
    assert found[-1] == pytest.approx(other.values["link.elongation"][-1], rel=0.005)


def test_what_hub_and_tip_carry_is_a_change_of_rank_two() -> None:
    model, component = bar_model(5), bar_link(5)
    base_row, tip_row, surface_row = model.loads.T
    p, u = component.start_values({**CARRIED, **DUTY})
    settled = component.settled(p)
    amplitudes = np.array([3.0, -2.0, 1.0, 0.5, 0.2])
    x = np.concatenate([amplitudes, np.zeros(component.x.size - 5)])
    found = component.rates_of(x, u, settled, 0.0)[:5]
    held = 2713.0 * 892.0 * model.volume * np.eye(5)
    held += CARRIED["hub_heat_capacity"] * np.outer(base_row, base_row)
    held += CARRIED["tip_heat_capacity"] * np.outer(tip_row, tip_row)
    ambient = DUTY["ambient_temperature"] + CARRIED["ambient_offset"] - COLD
    h = 4.55 + 6.4 * 2.0 * LENGTH / 2
    base = DUTY["heat_flow"] - CARRIED["hub_conductance"] * (base_row @ amplitudes - ambient)
    sink = COLD - DUTY["ambient_temperature"] + ambient
    tip = DUTY["tip_heat_flow"] - CARRIED["tip_conductance"] * (tip_row @ amplitudes - sink)
    gain = base_row * base + tip_row * tip
    gain += surface_row * (h * ambient + CARRIED["absorbed_flux"])
    gain -= (167.0 * np.diag(model.conduction) + h * model.cooling[0]) @ amplitudes
    assert found == pytest.approx(np.linalg.solve(held, gain), rel=1e-12)


@pytest.mark.parametrize("carried", [{}, {**CARRIED, "hub_conductance": 30.0}], ids=["bare", "carrying"])
def test_its_own_solution_of_stiff_equations_keeps_second_order(carried: dict[str, float]) -> None:
    """Conduction and the ends are solved implicitly; no explicit method takes such a conductance."""
    component, names = bar_link(13), ["elongation", "base_temperature"]
    exact = integrate(component, [Phase(60.0, DUTY)], names, every=60.0, parameters=carried).values
    errors = []
    for micro in (4.0, 2.0, 1.0):
        instance = started(replace(component, micro_step=micro), **carried, **DUTY)
        instance.step(0.0, 60.0)
        errors.append([instance.get(name) - exact[name][-1] for name in names])
    assert np.all(np.abs(errors[-1]) < [2e-9, 2e-3])
    assert np.all(np.abs(errors[0]) > 8 * np.abs(errors[-1]))


def test_radiation_is_a_coefficient_and_surfaces_have_factors() -> None:
    instance = started(bar_link(4), ambient_temperature=285.0, emissivity=0.9, radiation_temperature=300.0)
    loss = instance.get("surface_heat_loss")
    area = bar_model(4).area[0]
    assert loss == pytest.approx(area * (4.55 + 4 * 0.9 * 5.670374419e-8 * 300.0**3) * 10.15, rel=1e-12)
    shaded = started(bar_link(4), ambient_temperature=285.0, **{"convection_factor[1]": 0.5})
    assert shaded.get("surface_heat_loss") == pytest.approx(area * 4.55 * 5.075, rel=1e-12)


def test_a_uniform_rise_above_the_reference_is_growth_and_no_rotation() -> None:
    instance = started(bar_link(4), reference_temperature=285.15)
    assert instance.get("elongation") == pytest.approx(23.6e-6 * 10.0 * LENGTH, rel=1e-12)
    assert instance.get("displacement[1]") == instance.get("elongation")
    assert [instance.get(f"rotation[{i}]") for i in (1, 2, 3)] == [0.0, 0.0, 0.0]


def test_the_bound_is_that_of_the_largest_inputs_so_far() -> None:
    instance = started(bar_link(4), heat_flow=20.0)
    per_watt = ERROR_GAIN[:, 0] / 167.0 * [23.6e-6, 23.6e-6, 1.0]
    names = [f"{kind}_error_bound" for kind in ("displacement", "rotation", "temperature")]
    assert [instance.get(name) for name in names] == pytest.approx(20.0 * per_watt)
    instance.step(0.0, 60.0)
    instance.set({"heat_flow": -3.0})
    instance.step(60.0, 60.0)
    assert [instance.get(name) for name in names] == pytest.approx(20.0 * per_watt, rel=1e-6)


def test_a_conductivity_beyond_what_it_was_reduced_for_is_refused() -> None:
    with pytest.raises(InputError, match=r"conductivity: 300 W/\(m.K\) is too high; give at most 250"):
        started(bar_link(4), conductivity=300.0)

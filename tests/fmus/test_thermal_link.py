"""ThermalLink against closed forms, its conservation of energy and its orders of convergence."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import erf, erfc

from tests.fmus.links import (
    ALPHA,
    COLD,
    DIFFUSIVITY,
    PERIMETER,
    RHO,
    SECTION,
    C,
    K,
    cells_with,
    fin_exact,
    flat,
    order,
    steady,
    transient,
)
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.thermal_link.component import COMPONENT, thermal_link
from warmlink.fmus.thermal_link.equations import SMALLEST_STRETCH

# fin in steady state --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("base", "tip", "h"), [(0.0254, 0.3170, 7.75), (0.0, 0.3302, 7.75), (0.1, 0.2, 60.0)]
)
def test_steady_fin_is_met_to_second_order(base: float, tip: float, h: float) -> None:
    # An overhang of no length has a millionth of the link's.
    overhang = SMALLEST_STRETCH * 0.3302
    before, after = max(base, overhang), max(0.3302 - tip, overhang)
    exact = fin_exact(before, before + tip - base, before + tip - base + after, h, 5.0)
    values = {"heat_flow": 5.0, "base_position": base, "tip_position": tip, "convection_still": h}
    found = [steady(cells_with(n), values) for n in (32, 64, 128, 256)]
    for name, value in exact.items():
        # The overhangs' share of the nodes is rounded, hence not 2 to the digit.
        assert order([outputs[name] - value for outputs in found]) == pytest.approx(2, abs=0.1), name


def test_the_nominal_link_in_steady_state() -> None:
    exact = fin_exact(0.0254, 0.3170, 0.3302, 4.55, 5.0)
    found = steady(40, {"heat_flow": 5.0})
    for name, value in exact.items():
        rise = value - (COLD if "temperature" in name else 0.0)
        assert abs(found[name] - value) < 2e-4 * rise, name


@pytest.mark.parametrize("speed", [0.0, 0.3, 1.0, 3.0, 20.0])
def test_still_air_and_motion_may_combine_as_the_root_of_cubes(speed: float) -> None:
    still, moving = 4.55, 6.4 * speed * (0.3170 - 0.0254) / 2
    sums = {0.0: still + moving, 1.0: (still**3 + moving**3) ** (1 / 3)}
    for mixing, h in sums.items():
        found, wanted = (
            steady(40, {"heat_flow": 5.0, **each})["base_temperature"] - COLD
            for each in ({"speed": speed, "convection_mixing": mixing}, {"convection_still": h})
        )
        assert found == pytest.approx(wanted, rel=1e-3)


@pytest.mark.parametrize("exponent", [0.1, 1 / 3, 0.5])
def test_still_air_may_take_heat_with_a_power_of_the_rise(exponent: float) -> None:
    """Of one temperature throughout it loses Q = h A r (r / 10 K)^n; the approximant holds from 1 to 60 K."""
    surface = PERIMETER * 0.3302 + 2 * SECTION
    for rise in (-10.0, 1.0, 2.0, 10.0, 40.0, 60.0):
        link = Instance(COMPONENT)
        link.set({"initial_temperature": COLD + rise, "convection_rise_exponent": exponent})
        wanted = 4.55 * surface * rise * (abs(rise) / 10) ** exponent
        assert link.get("surface_heat_loss") == pytest.approx(wanted, rel=0.021)


def test_a_conductance_at_the_tip_draws_heat_as_a_fin_with_another_tip() -> None:
    """A tip conductance h A at the end face doubles that face's loss; a fin with twice the tip loss."""
    h = 7.75
    m = math.sqrt(h * PERIMETER / (K * SECTION))
    ratio, length = 2 * h / (m * K), 0.3302
    c, s = math.cosh(m * length), math.sinh(m * length)
    rise = 5.0 / (K * SECTION * m * (s + ratio * c) / (c + ratio * s) + h * SECTION)
    found = steady(
        321,
        {
            "heat_flow": 5.0,
            "base_position": 0.0,
            "tip_position": length,
            "convection_still": h,
            "tip_conductance": h * SECTION,
        },
    )
    assert found["base_temperature"] - COLD == pytest.approx(rise, rel=1e-5)
    assert found["tip_temperature"] - COLD == pytest.approx(rise / (c + ratio * s), rel=1e-5)


# semi-infinite solid --------------------------------------------------------------------------------------

# The whole link expands; its far end is not yet reached by the heat. Sensor 4 sits at a sixth of the length,
# where 48, 96 and 192 intervals have a node.
HALVED = (48, 96, 192)


def insulated(length: float) -> dict[str, float]:
    return {"length": length, "base_position": 0.0, "tip_position": length, "convection_still": 0.0}


def test_step_of_heat_flow_into_a_semi_infinite_solid() -> None:
    """T - T_0 = 2 Q / (k A) sqrt(a t) ierfc(x / 2 sqrt(a t)), Holman eq. (4-13 a)."""
    time, heat_flow, length = 300.0, 5.0, 0.9
    depth = math.sqrt(DIFFUSIVITY * time)

    def rise(x: float) -> float:
        z = x / (2 * depth)
        return 2 * heat_flow * depth / (K * SECTION) * (math.exp(-z * z) / math.sqrt(math.pi) - z * erfc(z))

    exact = {
        "base_temperature": COLD + rise(0.0),
        "sensor_temperature[4]": COLD + rise(length / 6),
    }
    found = [transient(cells_with(n), insulated(length), {"heat_flow": heat_flow}, time) for n in HALVED]
    for name, value in exact.items():
        assert order([outputs[name] - value for outputs in found]) == pytest.approx(2, abs=0.1), name
    growth = ALPHA * heat_flow * time / (RHO * C * SECTION)
    assert order([outputs["elongation"] - growth for outputs in found]) == pytest.approx(2, abs=0.1)
    assert found[-1]["elongation"] == pytest.approx(growth, rel=1e-3)
    assert found[-1]["heat_received"] == pytest.approx(heat_flow * time, rel=1e-8)


def test_held_base_temperature_on_a_semi_infinite_solid() -> None:
    """The rise is dT erfc(x / 2 sqrt(a t)); its integral is the corrected Eq. (4) of the paper.

    A very large hub conductance holds the base at the temperature of the surroundings, the surface being
    insulated.
    """
    time, step, length = 900.0, 14.0, 2.0
    depth = math.sqrt(DIFFUSIVITY * time)
    reach = length / (2 * depth)
    growth = length * (1 - erf(reach)) + 2 * depth / math.sqrt(math.pi) * (1 - math.exp(-(reach**2)))
    exact = {
        "sensor_temperature[4]": COLD + step * erfc(reach / 6),
        "elongation": ALPHA * step * growth,
    }
    held = {**insulated(length), "hub_conductance": 1e6}
    found = [transient(cells_with(n), held, {"ambient_temperature": COLD + step}, time) for n in HALVED]
    for name, value in exact.items():
        assert order([outputs[name] - value for outputs in found]) == pytest.approx(2, abs=0.15), name
    assert found[-1]["elongation"] == pytest.approx(exact["elongation"], rel=1e-4)
    assert found[-1]["base_temperature"] == pytest.approx(COLD + step, abs=1e-3)


# one lump -------------------------------------------------------------------------------------------------


def lump(micro_step: float, stop: float) -> tuple[float, float]:
    """Temperature rise found and exact of a link that conducts without limit."""
    component = dataclasses.replace(thermal_link(12), micro_step=micro_step)
    instance = Instance(component)
    instance.set({"conductivity": 1e12, "convection_still": 200.0, "heat_flow": 10.0})
    instance.initialize()
    instance.step(0.0, stop)
    area = PERIMETER * 0.3302 + 2 * SECTION
    conductance, capacity = 200.0 * area, RHO * C * SECTION * 0.3302
    exact = 10.0 / conductance * -math.expm1(-conductance * stop / capacity)
    return instance.get("base_temperature") - COLD, exact


def test_one_lump_to_second_order_in_the_micro_step() -> None:
    pairs = [lump(step, 64.0) for step in (8.0, 4.0, 2.0, 1.0)]
    assert order([found - exact for found, exact in pairs]) == pytest.approx(2, abs=0.1)
    found, exact = lump(0.125, 64.0)
    assert found == pytest.approx(exact, rel=1e-6)


def test_micro_steps_converge_to_second_order_on_a_link_that_radiates() -> None:
    extra = {"emissivity": 0.95, "conductivity_temperature_coefficient": 1e-3, "tip_heat_capacity": 20.0}
    inputs = {"heat_flow": 20.0, "speed": 3.43}
    exact = transient(40, extra, inputs, 600.0)
    steps = [20.0, 10.0, 5.0, 2.5]
    errors: dict[str, list[float]] = {"base_temperature": [], "elongation": []}
    for step in steps:
        instance = Instance(dataclasses.replace(COMPONENT, micro_step=step))
        instance.set({**extra, **inputs})
        instance.initialize()
        instance.step(0.0, 600.0)
        for name, row in errors.items():
            row.append(instance.get(name) - exact[name])
    for name, row in errors.items():
        assert order(row) == pytest.approx(2, abs=0.25), name
    assert abs(errors["elongation"][-1]) < 1e-9


# energy ---------------------------------------------------------------------------------------------------


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_heat_is_neither_made_nor_lost(seed: int) -> None:
    """What is stored is what comes in less what goes out, whatever the state, to rounding."""
    rng = np.random.default_rng(seed)
    instance = Instance(COMPONENT)
    instance.set(
        {
            "heat_flow": rng.normal() * 20,
            "tip_heat_flow": rng.normal() * 5,
            "tip_sink_temperature": COLD + rng.normal() * 10,
            "ambient_temperature": COLD + rng.normal() * 10,
            "speed": rng.uniform(0, 4),
            "emissivity": rng.uniform(0, 1),
            "absorbed_flux": rng.uniform(0, 50),
            "hub_conductance": rng.uniform(0, 1),
            "tip_heat_capacity": rng.uniform(0, 50),
            "hub_heat_capacity": rng.uniform(0, 50),
            "tip_conductance": rng.uniform(0, 1),
            "conductivity_temperature_coefficient": rng.uniform(-1e-3, 1e-3),
            "base_position": rng.uniform(0, 0.1),
            "tip_position": rng.uniform(0.2, 0.3302),
        }
    )
    p, u = flat(instance)
    x = np.append(COLD + rng.normal(size=40) * 20, 0.0)
    record, settled = COMPONENT.u.read(u), COMPONENT.d.read(p)
    outputs = COMPONENT.y.read(COMPONENT.outputs_of(x, u, p, 0.0))
    stored = float(np.sum(settled.heat_capacity * COMPONENT.rates_of(x, u, p, 0.0)[:-1]))
    gained = (
        record.heat_flow
        + record.tip_heat_flow
        - outputs.surface_heat_loss
        - settled.hub_conductance * (outputs.base_temperature - record.ambient_temperature)
        - settled.tip_conductance * (outputs.tip_temperature - record.tip_sink_temperature)
    )
    # Rounding is that of the heat conducted from node to node, some 1e5 W where neighbours differ by 20 K.
    assert stored == pytest.approx(gained, abs=1e-9)


def test_materials_that_vary_with_temperature_store_and_grow_as_much_as_they_say() -> None:
    """An insulated lump: heat and growth against the integrals of c and alpha over its temperature."""
    b, a, power, time = 1e-3, 2e-3, 50.0, 600.0
    instance = Instance(COMPONENT)
    insulated = {"convection_still": 0.0, "conductivity": 1e6, "hub_heat_capacity": 20.0, "heat_flow": power}
    varying = {"specific_heat_temperature_coefficient": b, "expansion_temperature_coefficient": a}
    instance.set({**insulated, **varying})
    instance.initialize()
    instance.step(0.0, time)
    nodes, start = np.array(instance.snapshot().states[:-1]) - COLD, COLD - 295.15
    rise = float(nodes.mean())
    assert rise > 50
    capacity = COMPONENT.d.read(flat(instance)[0]).heat_capacity
    assert capacity @ (nodes + b * ((start + nodes) ** 2 - start**2) / 2) == pytest.approx(
        power * time, rel=1e-6
    )
    counts = rise + a * ((start + rise) ** 2 - start**2) / 2
    assert instance.get("elongation") == pytest.approx(23.6e-6 * (0.3170 - 0.0254) * counts, rel=1e-3)
    constant = 23.6e-6 * (0.3170 - 0.0254) * rise
    assert instance.get("elongation") > 1.05 * constant


def test_an_insulated_link_keeps_all_that_it_receives() -> None:
    instance = Instance(COMPONENT)
    instance.set(
        {"convection_still": 0.0, "heat_flow": 7.0, "tip_heat_capacity": 15.0, "hub_heat_capacity": 40.0}
    )
    instance.initialize()
    for k in range(20):
        instance.step(k * 3.7, 3.7)
    capacity = COMPONENT.d.read(flat(instance)[0]).heat_capacity
    temperature = np.array(instance.snapshot().states[:-1])
    assert capacity.sum() == pytest.approx(RHO * C * SECTION * 0.3302 + 55.0, rel=1e-12)
    assert capacity @ (temperature - COLD) == pytest.approx(instance.get("heat_received"), rel=1e-10)
    assert instance.get("heat_received") == pytest.approx(7.0 * 74.0, rel=1e-12)


# air and reference ----------------------------------------------------------------------------------------


def test_still_air_and_motion_make_the_papers_coefficient() -> None:
    """7.75 W/(m2.K) at a mean linear speed of 0.5 m/s: speed such that |speed| L / 2 = 0.5."""
    moving = steady(40, {"heat_flow": 5.0, "speed": 2 * 0.5 / 0.2916})
    given_so = steady(40, {"heat_flow": 5.0, "convection_still": 4.55 + 6.4 * 0.5})
    assert moving["elongation"] == pytest.approx(given_so["elongation"], rel=1e-12)
    backwards = steady(40, {"heat_flow": 5.0, "speed": -2 * 0.5 / 0.2916})
    assert backwards["elongation"] == moving["elongation"]


def test_stretch_over_elongation_is_measured_from_the_reference() -> None:
    warm = Instance(COMPONENT)
    warm.set({"initial_temperature": 305.15, "reference_temperature": 295.15})
    warm.initialize()
    assert warm.get("elongation") == pytest.approx(ALPHA * 10 * 0.2916, rel=1e-12)

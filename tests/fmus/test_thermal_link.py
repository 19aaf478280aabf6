"""ThermalLink against closed forms, its conservation of energy and its orders of convergence."""

import dataclasses
import math
from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import erf, erfc

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.integrator import ComplexStepJacobian
from warmlink.fmus.component.reference import Phase, integrate
from warmlink.fmus.thermal_link.component import COMPONENT, thermal_link
from warmlink.fmus.thermal_link.grid import SMALLEST_STRETCH, positions, spacings, stretches

COLD = 295.15
SECTION, PERIMETER = 0.0254 * 0.00635, 2 * (0.0254 + 0.00635)
K, RHO, C, ALPHA = 167.0, 2713.0, 892.0, 23.6e-6
DIFFUSIVITY = K / (RHO * C)


def flat(instance: Instance) -> tuple[np.ndarray, np.ndarray]:
    """Settled parameters and inputs of an instance."""
    component = instance.component
    p = np.array([instance.get(name) for name in component.p.names])
    return component.settled(p), np.array([instance.get(name) for name in component.u.names])


def steady(cells: int, values: Mapping[str, float]) -> Mapping[str, float]:
    """Outputs in steady state; the equations are linear, so that one Newton step finds it."""
    component = thermal_link(cells)
    instance = Instance(component)
    instance.set(values)
    p, u = flat(instance)
    x = component.states_at_start(u, p)

    def temperatures(z: np.ndarray) -> np.ndarray:
        return component.rates_of(np.append(z, 0.0), u, p, 0.0)[:-1]

    jacobian = ComplexStepJacobian(np.ones((cells, cells), dtype=bool))(temperatures, x[:-1])
    solution = x[:-1] - np.linalg.solve(jacobian, temperatures(x[:-1]))
    return dict(
        zip(component.y.names, component.outputs_of(np.append(solution, 0.0), u, p, 0.0), strict=True)
    )


def transient(cells: int, parameters: Mapping[str, float], inputs: Mapping[str, float], time: float) -> dict:
    """Outputs at a time, with no error but the grid's."""
    names = (
        "base_temperature",
        "tip_temperature",
        "sensor_temperature[4]",
        "elongation",
        "discretisation_error",
        "heat_received",
    )
    found = integrate(thermal_link(cells), [Phase(time, inputs)], names, every=time, parameters=parameters)
    return {n: float(found.values[n][-1]) for n in names}


def cells_with(between: int) -> int:
    """Count of cells that puts so many intervals between base and tip."""
    return next(n for n in range(between, 2 * between) if stretches(n).between == between)


def order(errors: list[float]) -> float:
    """Observed order of errors on grids or steps halved from one to the next."""
    return math.log2(abs(errors[0] / errors[-1])) / (len(errors) - 1)


# fin in steady state --------------------------------------------------------------------------------------


def fin_admittance(length: float, h: float) -> float:
    """Heat flow a kelvin into a fin that loses heat at its tip too, Holman eq. (2-34)."""
    m = math.sqrt(h * PERIMETER / (K * SECTION))
    ratio = h / (m * K)
    s, c = math.sinh(m * length), math.cosh(m * length)
    return K * SECTION * m * (s + ratio * c) / (c + ratio * s)


def fin_share(x: float, length: float, h: float) -> float:
    """Temperature rise over that at the root, Holman eq. (2-33 b)."""
    m = math.sqrt(h * PERIMETER / (K * SECTION))
    ratio = h / (m * K)
    rest = m * (length - x)
    return (math.cosh(rest) + ratio * math.sinh(rest)) / (
        math.cosh(m * length) + ratio * math.sinh(m * length)
    )


def fin_exact(base: float, tip: float, length: float, h: float, heat_flow: float) -> dict[str, float]:
    rise = heat_flow / (fin_admittance(base, h) + fin_admittance(length - base, h))
    x = np.linspace(0, tip - base, 4001)
    shares = np.array([fin_share(each, length - base, h) for each in x])
    mean = float(np.trapezoid(shares, x))
    return {
        "base_temperature": COLD + rise,
        "tip_temperature": COLD + rise * shares[-1],
        "sensor_temperature[2]": COLD + rise * fin_share((tip - base) / 2, length - base, h),
        "elongation": ALPHA * rise * mean,
    }


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


def test_an_insulated_link_keeps_all_that_it_receives() -> None:
    instance = Instance(COMPONENT)
    instance.set({"convection_still": 0.0, "heat_flow": 7.0, "tip_heat_capacity": 15.0})
    instance.initialize()
    for k in range(20):
        instance.step(k * 3.7, 3.7)
    capacity = COMPONENT.d.read(flat(instance)[0]).heat_capacity
    temperature = np.array(instance.snapshot().states[:-1])
    assert capacity.sum() == pytest.approx(RHO * C * SECTION * 0.3302 + 15.0, rel=1e-12)
    assert capacity @ (temperature - COLD) == pytest.approx(instance.get("heat_received"), rel=1e-10)
    assert instance.get("heat_received") == pytest.approx(7.0 * 74.0, rel=1e-12)


# grid -----------------------------------------------------------------------------------------------------


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

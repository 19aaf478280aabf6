"""Linear plant and its reduction: against the components themselves and against python-control."""

import numpy as np
import pytest
from scipy import linalg

from warmlink.controllers.design.gains import uniform_profile
from warmlink.controllers.design.plant import (
    INPUTS,
    OUTPUTS,
    USUAL_SPEED,
    LinearPlant,
    cell_plant,
    plant_model,
)
from warmlink.controllers.design.reduction import (
    CHECKED_SPEEDS,
    PRECISIONS,
    SIZES,
    ReducedPlant,
    balanced,
    reduce_plant,
)
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.component.reference import integrate
from warmlink.fmus.errors import InputError
from warmlink.fmus.plant import demand
from warmlink.fmus.plant import plant as motor_and_link


@pytest.fixture(scope="module")
def plant() -> LinearPlant:
    return plant_model()


def test_still_air_counts_in_the_linear_plant_as_at_its_ordinary_rise(plant: LinearPlant) -> None:
    buoyant = plant_model(cell_plant(link={"convection_rise_exponent": 0.25}))
    for speed in (0.0, USUAL_SPEED):
        np.testing.assert_array_equal(buoyant.at(speed)[0], plant.at(speed)[0])


@pytest.mark.parametrize(
    "start",
    [{"initial_temperature": 275.15}, {"initial_temperature_rise[1]": 20.0}],
    ids=["cold", "warm base"],
)
@pytest.mark.parametrize("coefficient", ["specific_heat", "conductivity"])
def test_where_a_run_begins_changes_nothing_of_the_linear_plant(
    coefficient: str, start: dict[str, float]
) -> None:
    """Linear about room temperature: a link that began cold stood cold in a warm room."""
    varies = {f"{coefficient}_temperature_coefficient": 4e-3}
    one, other = (plant_model(cell_plant(link=link)) for link in (varies, {**varies, **start}))
    for speed in (0.0, USUAL_SPEED):
        for mine, theirs in zip(one.at(speed), other.at(speed), strict=True):
            np.testing.assert_array_equal(mine, theirs)


@pytest.mark.parametrize("mixing", [0.0, 1.0, 1.8])
def test_the_linear_plant_follows_the_components(mixing: float) -> None:
    """Friction at the usual speed, no current: linear but for the speed, so the two are one."""
    plant = plant_model(cell_plant(link={"convection_mixing": mixing}))
    speed, span = USUAL_SPEED, 1800.0
    run = integrate(
        motor_and_link(),
        [demand(span, speed, 0.0)],
        ("link.elongation", "link.tip_temperature", "motor.winding_temperature"),
        every=600.0,
        tolerance=1e-9,
        parameters={"link.convection_mixing": mixing},
    )
    A, B = plant.at(speed)
    heat = np.zeros(len(INPUTS))
    heat[INPUTS.index("winding_heat")] = 0.15 * speed**2
    heat[INPUTS.index("shaft_heat")] = (1.5 + 0.6 * speed) * speed
    for k, time in enumerate(run.time):
        state = np.linalg.solve(A, (linalg.expm(A * time) - np.eye(A.shape[0])) @ (B @ heat))
        y = dict(zip(OUTPUTS, plant.C @ state, strict=True))
        assert y["elongation"] == pytest.approx(run.values["link.elongation"][k], abs=2e-11)
        for name, key in (("tip_temperature", "link"), ("winding_temperature", "motor")):
            assert y[name] + ROOM_TEMPERATURE == pytest.approx(run.values[f"{key}.{name}"][k], abs=2e-5)


def test_heat_goes_where_it_is_said_to_go(plant: LinearPlant) -> None:
    for i, name in enumerate(INPUTS[:3]):
        assert plant.heat_capacity @ plant.B[:, i] == pytest.approx(1.0, rel=1e-12), name
    winding, shaft = plant.B[0, 0], plant.B[1, 1]
    assert (1 / winding, 1 / shaft) == pytest.approx((200.0, 1500.0), rel=1e-12)


def test_equal_temperatures_everywhere_are_an_equilibrium(plant: LinearPlant) -> None:
    ones = np.ones(plant.heat_capacity.size)
    for speed in (0.0, 3.0):
        A, B = plant.at(speed)
        assert np.abs(A @ ones + B[:, INPUTS.index("ambient_temperature")]).max() < 1e-12 * np.abs(A).max()


@pytest.mark.parametrize("order", [4, 7, 10])
def test_the_truncation_keeps_its_bound(plant: LinearPlant, order: int) -> None:
    form = balanced(plant)
    basis = form.vectors[:, :order]
    state, ports = basis.T @ form.state @ basis, basis.T @ form.ports
    worst = 0.0
    for frequency in [0.0, *np.logspace(-6, 1, 71)]:
        full = form.ports.T @ np.linalg.solve(1j * frequency * np.eye(42) - form.state, form.ports)
        small = ports.T @ np.linalg.solve(1j * frequency * np.eye(order) - state, ports)
        worst = max(worst, float(linalg.norm(full - small, 2)))
    assert form.hankel[order] <= worst * (1 + 1e-6), "no reduction of this order can do better than that"
    assert worst <= 2 * form.hankel[order:].sum(), "the bound of truncation"


@pytest.mark.parametrize("order", [4, 7, 10])
def test_the_reduced_plant_is_stable_at_every_speed(plant: LinearPlant, order: int) -> None:
    reduced = reduce_plant(plant, order)
    for speed in (0.0, 3.43, 10.0):
        values = np.linalg.eigvals(np.diag(reduced.rate) + speed * reduced.A_speed)
        assert values.real.max() < 0
        assert np.abs(values.imag).max() < 1e-12


def test_python_control_sees_the_same_plant_reduced_and_not(plant: LinearPlant) -> None:
    reduced = reduce_plant(plant, 7)
    for speed in (0.0, 3.43):
        full, small = plant.state_space(speed), reduced.state_space(speed)
        slowest = [np.sort(-model.poles().real)[:4] for model in (full, small)]
        assert slowest[1] == pytest.approx(slowest[0], rel=1e-2)
        shaft_to_growth = [
            model["elongation", "shaft_heat"].frequency_response([0.0, 1e-4, 1e-3]).complex
            for model in (full, small)
        ]
        assert shaft_to_growth[1] == pytest.approx(shaft_to_growth[0], rel=1e-3)


def test_what_the_readme_says_the_reduction_costs(plant: LinearPlant) -> None:
    reduced = [reduce_plant(plant, order) for order in (5, 7, 10)]
    assert reduced[1].error.elongation_step < 2e-9
    assert reduced[1].error.temperature_step < 0.002
    norms = [h_infinity(plant, each) for each in reduced]
    assert norms[0] > norms[1] > norms[2]


def h_infinity(plant: LinearPlant, reduced: ReducedPlant) -> float:
    """H-infinity norm of the error, from ordinary inputs to outputs by their precision, by a sweep."""
    worst, sizes = 0.0, np.array([SIZES[name] for name in INPUTS])
    precisions = np.array([PRECISIONS[name] for name in OUTPUTS])[:, None]
    for speed in CHECKED_SPEEDS:
        (A, B), (a, b) = plant.at(speed), reduced.at(speed)
        for s in 1j * np.array([0.0, *np.logspace(-6, 1, 141)]):
            full = plant.C @ np.linalg.solve(s * np.eye(len(A)) - A, B)
            small = reduced.C @ np.linalg.solve(s * np.eye(len(a)) - a, b)
            worst = max(worst, float(linalg.norm((full - small) * sizes / precisions, 2)))
    return worst


def test_a_kelvin_everywhere_is_a_kelvin_at_every_sensor(plant: LinearPlant) -> None:
    reduced = reduce_plant(plant, 7)
    seen = reduced.C @ uniform_profile(reduced)
    assert seen[:-1] == pytest.approx(1.0, abs=3e-4)
    assert seen[-1] == pytest.approx(plant.elongation_per_kelvin, rel=3e-4)


def test_a_plant_is_reduced_to_one_state_at_least_and_to_no_more_than_it_has(plant: LinearPlant) -> None:
    states = plant.heat_capacity.size
    assert [reduce_plant(plant, order).A.shape[0] for order in (1, states)] == [1, states]
    for order in (0, states + 1):
        with pytest.raises(InputError, match=f"order: {order} is not possible; .* give 1 to {states}"):
            reduce_plant(plant, order)

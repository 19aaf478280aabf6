"""Gains and fitted laws: against the components themselves and against scipy."""

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from scipy import linalg

from warmlink.controllers.design.gains import Unknown, design_controller
from warmlink.controllers.design.middle import middle_advice
from warmlink.controllers.design.plant import (
    INPUTS,
    OUTPUTS,
    USUAL_SPEED,
    LinearPlant,
    Plant,
    cell_plant,
    plant_model,
)
from warmlink.controllers.design.reduction import (
    reduce_plant,
)
from warmlink.controllers.design.regression import fit_regression, reference_temperature_of
from warmlink.controllers.design.shipped import as_json, shipped_values
from warmlink.controllers.design.training import TrainingRun, training_run
from warmlink.controllers.matrices import symmetric
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer.filters import filters_of
from warmlink.controllers.start_values import Values, by_scalar, design_file, shipped_design
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.reference import integrate
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.motor_heat_source.equations import copper_loss
from warmlink.fmus.plant import demand
from warmlink.fmus.plant import plant as motor_and_link

SHIPPED: Mapping[str, Values] = {
    law: shipped_design(law) for law in ("observer", "observer_drift", "regression", "linear_observer")
}


@pytest.fixture(scope="module")
def plant() -> LinearPlant:
    return plant_model()


@pytest.fixture(scope="module")
def designed_now() -> Mapping[str, Values]:
    return shipped_values()


@pytest.mark.parametrize("name", SHIPPED)
def test_the_shipped_parameter_sets_are_reproduced(name: str, designed_now: Mapping[str, Values]) -> None:
    now = designed_now[name]
    assert now.keys() == SHIPPED[name].keys()
    for key, value in now.items():
        scale = np.abs(np.atleast_1d(np.array(value))).max()
        assert np.array(SHIPPED[name][key]) == pytest.approx(np.array(value), rel=1e-6, abs=1e-8 * scale), key
    assert as_json(SHIPPED[name]) == design_file(name).read_text("utf-8"), "as `write_all` writes it"


def left_by_less_loss(plant: Plant) -> float:
    """K at three thermometers that no heat in shaft and link explains, where the link loses a fifth less."""
    convection = {"link.convection_still": 0.8 * 4.55, "link.convection_per_speed": 0.8 * 6.4}
    rises = []
    for each in (plant, replace(plant, given={**plant.given, **convection})):
        model = plant_model(each)
        rise = model.C @ np.linalg.solve(-model.A, model.B)
        rises.append(rise[[OUTPUTS.index(f"{name}_temperature") for name in ("base", "middle", "tip")], 1:3])
    thought, true = rises
    _, squares, _, _ = np.linalg.lstsq(thought, true[:, 0], rcond=None)
    return float(np.sqrt(squares[0]))


def test_what_is_unknown_goes_by_the_plant() -> None:
    """A slender steel link: losses that were misjudged change how far the shaft's heat reaches into it."""
    steel = {
        "length": 0.8,
        "tip_position": 0.78,
        "conductivity": 53.3,
        "density": 7850.0,
        "specific_heat": 441.0,
    }
    design = design_controller(plant=cell_plant(link=steel))
    largest = np.array(design.parameters["profile_std"]) * np.abs(design.reduced.C[:-1]).max(axis=0)
    contradiction = [left_by_less_loss(cell_plant(link=each)) for each in (steel, {})]
    assert largest == pytest.approx(0.003 * contradiction[0] / contradiction[1], rel=1e-6)
    assert largest[0] > 0.03
    shaft, link = np.array(design.parameters["disturbance_std"])
    assert (shaft, link) == (20.0, pytest.approx(0.143, abs=0.001))
    assert design.parameters["quiet_share"] == pytest.approx(1 - 0.003 / largest.max(), abs=1e-9)


def test_a_middle_thermometer_that_stays_cold_is_told() -> None:
    assert middle_advice(cell_plant()) is None
    slender = {"length": 0.8, "tip_position": 0.78, "conductivity": 53.3}
    told = middle_advice(cell_plant(link=slender))
    assert told is not None
    found = re.fullmatch(r"thermometers: .* at 403 mm, rises by (\S+) %.*\[2\] = (\d+) mm", told)
    assert found is not None
    plant = plant_model(cell_plant(link={**slender, "sensor_position[2]": float(found[2]) / 1e3}))
    A, B = plant.at(USUAL_SPEED)
    rise = plant.C @ np.linalg.solve(-A, B[:, INPUTS.index("shaft_heat")])
    assert float(found[1]) < 5
    assert rise[OUTPUTS.index("middle_temperature")] / rise[
        OUTPUTS.index("base_temperature")
    ] == pytest.approx(0.2, abs=0.03)


@pytest.mark.parametrize(
    "sensors", [("base", "tip"), ("shaft",), ("shaft", "winding", "base", "middle", "tip")]
)
def test_the_laws_recursion_ends_at_the_steady_kalman_gain(sensors: tuple[str, ...]) -> None:
    """The covariance in the law, at a constant speed, against scipy's solution of the Riccati equation."""
    design = design_controller(sensors=sensors, unknown=Unknown(shaft_heat_time=400.0, link_heat_time=300.0))
    speed, step, sigma = 3.0, 10.0, 0.1
    values, reduced = design.parameters, design.reduced
    decay, fade = np.exp(reduced.rate * step), np.exp(-step / np.array(values["disturbance_time"]))
    reach = (decay - 1) / reduced.rate
    F = np.zeros((9, 9))
    F[:7, :7] = np.diag(decay + reach * speed * np.diag(reduced.A_speed))
    F[:7, 7] = reach * reduced.B[:, 1]
    F[:7, 8] = reach * reduced.B[:, 2]
    F[7:, 7:] = np.diag(fade)
    Q = np.diag(
        [
            *(np.array(values["profile_std"]) ** 2 * (1 - decay**2)),
            *(np.array(values["disturbance_std"]) ** 2 * (1 - fade**2)),
        ]
    )
    rows = [i for i, name in enumerate(OUTPUTS[:5]) if name.removesuffix("_temperature") in sensors]
    C = np.zeros((len(rows), 9))
    C[:, :7] = reduced.C[rows]

    instance = Instance(OBSERVER)
    no_loss = dict.fromkeys(("coulomb_friction", "viscous_friction", "iron_loss_coefficient"), 0.0)
    share = 0.5
    instance.set({**by_scalar(values), **no_loss, "speed": speed, "sample_time": step, "stuck_time": 1e9})
    instance.set({"quiet_share": share})
    instance.initialize()
    instance.step(0.0, 4000.0)
    found = filters_of(OBSERVER.x.read(np.array(instance.snapshot().states)))
    for belief, expected in ((found.alert, 1.0), (found.quiet, share)):
        before = linalg.solve_discrete_are(F.T, C.T, expected**2 * Q, sigma**2 * np.eye(len(rows)))
        innovation = C @ before @ C.T + sigma**2 * np.eye(len(rows))
        after = before - before @ C.T @ np.linalg.solve(innovation, C @ before)
        std = np.sqrt(np.diag(after))
        assert np.abs(symmetric(belief.spread, 9) - after) / np.outer(std, std) == pytest.approx(
            0.0, abs=2e-3
        )


def test_losses_in_the_law_are_the_motors(plant: LinearPlant) -> None:
    """A heavy torque warms the winding, whose resistance grows: the law computes it with its own estimate."""
    instance = Instance(OBSERVER)
    instance.set({"torque": 4.0, "sample_time": 10.0, **{f"sensor_std[{i}]": 0.0 for i in range(1, 6)}})
    instance.initialize()
    instance.step(0.0, 7200.0)
    run = integrate(
        motor_and_link(),
        [demand(7200.0, 0.0, 4.0)],
        ("link.elongation", "motor.winding_temperature"),
        every=7200.0,
        tolerance=1e-8,
    )
    assert instance.get("predicted_elongation") == pytest.approx(run.values["link.elongation"][-1], rel=1e-3)
    p, u = (
        MOTOR.p.read(np.array([s.start for s in MOTOR.scalars()][: MOTOR.p.size])),
        MOTOR.u.read(np.zeros(MOTOR.u.size)),
    )
    warm = copper_loss(run.values["motor.winding_temperature"][-1], u._replace(torque=4.0), p)
    assert warm > 1.05 * copper_loss(293.15, u._replace(torque=4.0), p), "the test is of a warm winding"


@pytest.mark.parametrize("mixing", [0.5, 1.1, 1.8])
def test_a_law_is_designed_where_moving_air_cools_hardly_more_than_still_air(mixing: float) -> None:
    design = design_controller(plant=cell_plant(link={"convection_mixing": mixing}))
    instance = Instance(OBSERVER)
    instance.set(by_scalar(design.parameters))
    instance.initialize()


def test_bad_designs_are_refused_in_a_sentence() -> None:
    with pytest.raises(InputError, match="'elbow' is not measured in the cell; choose shaft, winding"):
        design_controller(sensors=("elbow",))
    with pytest.raises(InputError, match="law: 'lag' has no design"):
        design_controller("lag")
    with pytest.raises(InputError, match="sensor_std: -1 K for base_temperature is not positive"):
        design_controller(sensors=("base",), sensor_std=-1.0)
    with pytest.raises(InputError, match=r"link\.width: -0\.02 m is not positive"):
        design_controller(plant=cell_plant(link={"width": -0.02}))
    with pytest.raises(InputError, match="design: heat of the shaft does not reach the link"):
        design_controller(plant=cell_plant(motor={"joint_conductance": 0.0}))
    with pytest.raises(InputError, match=r"link\.colour: ThermalLink has no such variable"):
        plant_model(cell_plant(link={"colour": 1.0}))
    with pytest.raises(InputError, match="order: 0 is not possible; the plant has 42 states"):
        reduce_plant(plant_model(), 0)


def test_the_regression_is_the_textbooks() -> None:
    run = training_run()
    sensors = ("shaft", "middle", "tip")
    values = fit_regression(run, sensors, sensor_std=0.2)
    used = run.temperature[:, [0, 3, 4]] - 295.15
    count = len(run.elongation)
    coefficients = np.linalg.solve(used.T @ used / count + 0.04 * np.eye(3), used.T @ run.elongation / count)
    from warmlink.controllers.regression.component import COMPONENT as REGRESSION

    readings = 295.15 + np.array([15.0, 0.0, 0.0, 9.0, 8.0])
    instance = Instance(REGRESSION)
    names = ("shaft", "winding", "base", "middle", "tip")
    instance.set({f"{name}_temperature": value for name, value in zip(names, readings, strict=True)})
    instance.set({**by_scalar(values), "correction_rate_limit": 1.0})
    instance.initialize()
    expected = coefficients @ (readings[[0, 3, 4]] - 295.15)
    assert instance.get("predicted_elongation") == pytest.approx(expected, rel=1e-6)


def test_the_growth_counts_from_where_the_link_begins_or_from_what_it_says() -> None:
    def designed(**link: float) -> float:
        return float(design_controller(plant=cell_plant(link=link)).parameters["reference_temperature"])  # type: ignore[arg-type]

    assert designed() == 295.15
    assert designed(initial_temperature=288.15) == pytest.approx(288.15, abs=1e-6)
    assert designed(reference_temperature=291.15) == pytest.approx(291.15, abs=1e-6)
    uneven = {"initial_temperature": 300.0, "initial_temperature_rise[3]": 4.0}
    assert designed(**uneven) == pytest.approx(300.0, abs=1e-6)


def test_a_run_begins_at_the_temperature_of_no_growth() -> None:
    taught = training_run()
    cold = TrainingRun(taught.temperature - 20.0, taught.elongation)
    assert reference_temperature_of(cold, ("base", "tip")) == pytest.approx(275.15)
    assert (
        reference_temperature_of(TrainingRun(cold.temperature, cold.elongation + 1e-6), ("base", "tip"))
        == 295.15
    )
    moments = fit_regression(cold, reference_temperature=reference_temperature_of(cold, ("base", "tip")))[
        "moments"
    ]
    assert moments == pytest.approx(fit_regression(taught)["moments"])


def test_a_run_that_cannot_teach_is_refused() -> None:
    with pytest.raises(InputError, match="2 rows are too few for a regression; give at least 12"):
        fit_regression(TrainingRun(np.full((2, 5), 300.0), np.zeros(2)))
    with pytest.raises(InputError, match="is not finite; leave such rows out"):
        fit_regression(TrainingRun(np.full((50, 5), np.nan), np.zeros(50)))

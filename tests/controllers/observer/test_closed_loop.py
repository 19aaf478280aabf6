"""The observers in closed loop with the cell: what they remove, how honest they are, what faults do to them.

Samples of what `trials` runs at length; the noise is that of the design, 0.1 K a reading.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
import pytest
from scipy import stats

from benchmarks.innovations import innovations, led_by_alert, whiteness
from benchmarks.law_trials import (
    FILTER_ALONE,
    Fault,
    coverage,
    fault_runs,
    instruments,
    mismatched,
    removed_percent,
    told_of_their_heat,
    worse_by,
)
from benchmarks.rollout import RECORDED, Cell, Record, demand_table, library
from warmlink.controllers.design.gains import design_controller
from warmlink.controllers.design.plant import Plant
from warmlink.controllers.observer import model
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer_drift.component import COMPONENT as DRIFT
from warmlink.controllers.regression.component import COMPONENT as REGRESSION
from warmlink.controllers.start_values import by_scalar
from warmlink.fmus import faults
from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.motor_heat_source.equations import PAD_POWER, PAD_TEMPERATURE
from warmlink.fmus.plant import plant
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.scenarios.duties.duty_files import load

TOLERANCE = 5e-6

CellOf = Callable[[Component], Cell]


@pytest.fixture(scope="session")
def cell_of() -> CellOf:
    made: dict[str, Cell] = {}

    def of(law_component: Component) -> Cell:
        name = law_component.name
        if name not in made:
            made[name] = Cell(law_component, law_states=True)
        return made[name]

    return of


def of_part(plant: Plant, part: str) -> dict[str, float]:
    """Parameters of the motor or the link that differ from nominal."""
    beginning = f"{part}."
    return {n.removeprefix(beginning): v for n, v in plant.given.items() if n.startswith(beginning)}


def run(
    cell: Cell,
    duty: str,
    seed: int = 1,
    plant_seed: int = 0,
    stop_time: float | None = None,
    law: Mapping[str, float] = MappingProxyType({}),
) -> Record:
    plant = mismatched(plant_seed)
    values = {**instruments(seed), **{part: of_part(plant, part) for part in ("motor", "link")}}
    values["compensator"] = dict(law)
    return cell.run(demand_table(load(duty), cell.step, stop_time), values)


pytestmark = pytest.mark.xdist_group("closed_loop")


def test_the_cell_in_one_step_is_the_joined_plant_s_instance(cell_of: CellOf) -> None:
    """Motor and link as the Python instance of both in one piece gives them."""
    record = run(cell_of(OBSERVER), "windshield_wiper", stop_time=120.0)
    both = Instance(plant())
    both.set({"motor.speed": 3.43, "motor.torque": 2.5, "link.speed": 3.43})
    both.initialize()
    for k in range(120):
        both.step(float(k), 1.0)
    assert record["elongation"][-1] == pytest.approx(both.get("link.elongation"), rel=1e-9)
    assert record["shaft_temperature"][-1] == pytest.approx(both.get("motor.shaft_temperature"), rel=1e-12)


@pytest.mark.parametrize("component", [OBSERVER, DRIFT], ids=lambda c: c.name)
@pytest.mark.parametrize("duty", [duty.name for duty in library()])
def test_no_duty_cycle_needs_a_warm_up(cell_of: CellOf, component: Component, duty: str) -> None:
    record = run(cell_of(component), duty)
    assert removed_percent(record) >= 98.0
    assert np.abs(record.error).max() < TOLERANCE
    assert record["distrusted"].mean() < 0.01


@pytest.mark.parametrize(("component", "least"), [(OBSERVER, 93.0), (DRIFT, 97.0)], ids=["observer", "drift"])
@pytest.mark.parametrize("duty", ["heavy_payload", "still_with_pad", "stop_and_go", "pick_and_place_slow"])
def test_a_wrong_model_costs_little(cell_of: CellOf, component: Component, least: float, duty: str) -> None:
    """Every thermal parameter off by up to 20 %, the expansion coefficient by up to 3 %."""
    for seed in (8, 9, 10):
        record = run(cell_of(component), duty, seed, plant_seed=seed)
        assert removed_percent(record) >= least
        assert record["distrusted"].mean() < 0.01, "a wrong model is no fault of a sensor"


@pytest.mark.slow
def test_regression_is_worse_than_the_observer(cell_of: CellOf) -> None:
    for duty in ("windshield_wiper", "still_with_pad", "stop_and_go"):
        simple, better = (removed_percent(run(cell_of(each), duty)) for each in (REGRESSION, OBSERVER))
        assert 90.0 < simple < better


@pytest.mark.parametrize("component", [OBSERVER, DRIFT], ids=lambda c: c.name)
def test_two_standard_deviations_cover_95_percent_at_nominal(cell_of: CellOf, component: Component) -> None:
    """Over duty cycles whose heat the law is told of; with a pad it is not, and rightly says less."""
    told = told_of_their_heat()
    shares = [
        coverage(run(cell_of(component), told[seed].name, seed + 1, stop_time=7200.0, law=FILTER_ALONE))
        for seed in range(len(told))
    ]
    assert 0.93 <= np.mean(shares) <= 0.97
    assert coverage(run(cell_of(component), "still_with_pad", law=FILTER_ALONE)) >= 0.93


def test_thermometers_better_than_the_model_leave_its_error(cell_of: CellOf) -> None:
    """With 0.02 K the reduced model's own hundredth of a micrometre is half of what is stated."""
    design = design_controller("observer", sensor_std=0.02).parameters
    shares = []
    for place, duty in enumerate(("continuous", "heavy_payload", "stop_and_go")):
        values = {**instruments(place + 1, noise=0.02), "compensator": {**by_scalar(design), **FILTER_ALONE}}
        shares.append(coverage(cell_of(OBSERVER).run(demand_table(load(duty), 1.0), values)))
    assert np.mean(shares) > 0.87
    assert min(shares) > 0.75


def test_innovations_are_white_and_of_the_size_stated(cell_of: CellOf) -> None:
    """Ljung and Box's test on each sensor's innovations, at nominal parameters, heat being told of.

    Of white series, 5 in 100 are rejected at 5 %. A gain that never quite goes to zero leaves a correlation
    of neighbours of some thousandths, which the test hardly finds in 2,700 samples.
    """
    told = told_of_their_heat()
    found = []
    for seed in range(3 * len(told)):
        demands = demand_table(told[seed % len(told)], 1.0, 3000.0)
        record = cell_of(OBSERVER).run(demands, instruments(seed + 1))
        found += [whiteness(series) for series in innovations(record).values()]
    assert len(found) == 6 * len(told)
    assert sum(each.p < 0.05 for each in found) <= stats.binom.ppf(0.999, len(found), 0.05)
    assert abs(np.mean([each.neighbours for each in found])) < 0.01
    assert np.mean([each.std for each in found]) == pytest.approx(1.0, abs=0.005)
    assert max(abs(each.mean) for each in found) < 4 / np.sqrt(2700)


def test_the_alert_filter_leads_while_heat_is_about_that_nothing_tells_of(cell_of: CellOf) -> None:
    """A pad of 20 W for 20 minutes: the quiet filter leads until then, and again when it is long gone."""
    plain = demand_table(load("windshield_wiper"), 1.0, 7000.0)
    demands = plain.copy()
    padded = slice(1500, 2700)
    demands[padded, 3], demands[padded, 5] = PAD_POWER, 20.0
    spans = []
    for seed in range(1, 7):
        with_pad, without = (cell_of(OBSERVER).run(each, instruments(seed)) for each in (demands, plain))
        led = led_by_alert(with_pad)
        assert led[1600:2700].all(), "from 100 s after the pad came on"
        assert not led[-100:].any()
        spans.append(led[300:1500].mean())
        last = np.flatnonzero(led)[-1]
        std = with_pad["correction_std"]
        assert std[last + 1] == pytest.approx(std[last], rel=0.02), "no jump when the quiet filter goes on"
        assert std[2000] > 2 * without["correction_std"][2000]
        assert np.abs(with_pad.error).max() < 0.1 * TOLERANCE
        assert without.error[1500:].std() < 0.6 * with_pad.error[padded].std()
    assert np.mean(spans) < 0.05


def test_an_expansion_error_is_no_heat(cell_of: CellOf) -> None:
    """What the camera teaches of a coefficient that is off leaves the quiet filter in the lead."""
    expansion = 1.03 * float(next(v.start for v in LINK.parameters if v.name == "expansion_coefficient"))
    values = {**instruments(1), "link": {"expansion_coefficient": expansion}}
    record = cell_of(DRIFT).run(demand_table(load("stop_and_go"), 1.0), values)
    assert led_by_alert(record, DRIFT).mean() < 0.02
    scale = DRIFT.x.index[f"estimate[{2 * (model.STATES + 1)}]"]
    assert record.values[-1, len(RECORDED) + scale] == pytest.approx(0.03, abs=0.01)


# faults ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("component", [OBSERVER, DRIFT], ids=lambda c: c.name)
def test_no_fault_makes_it_worse_than_no_compensation(cell_of: CellOf, component: Component) -> None:
    """A sample of the thousand that `trials.fault_runs` does."""
    runs = list(fault_runs(cell_of(component), library(), range(24), with_camera=component is DRIFT))
    assert max(each.worse_by for each in runs) <= TOLERANCE
    for each in runs:
        if each.fault.kind == faults.DROPOUT and each.fault.instrument != "camera":
            assert each.delay is not None
            assert each.delay <= 1.0
    leaps = [e for e in runs if e.fault.kind == faults.JUMP and abs(e.fault.size) > 1.0]
    assert leaps
    assert all(each.delay is not None for each in leaps)


@pytest.mark.parametrize("instrument", ["base_temperature", "tip_temperature"])
@pytest.mark.parametrize("rate", [-15.0, 15.0])
def test_a_drifting_sensor_is_found_by_contradiction(cell_of: CellOf, instrument: str, rate: float) -> None:
    fault = Fault(instrument, faults.DRIFT, 1200.0, 0.0, rate / 3600)
    cell = cell_of(OBSERVER)
    record = cell.run(demand_table(load("windshield_wiper"), 1.0), fault.applied(instruments(1)))
    assert record["distrusted"][1200:].any()
    assert worse_by(record) <= TOLERANCE
    # The other sensor and the duty carry on: the last error is a fraction of the growth.
    assert abs(record.error[-1]) < 0.25 * record["elongation"][-1]


def test_a_stuck_sensor_is_found_when_the_cell_moves_on(cell_of: CellOf) -> None:
    fault = Fault("base_temperature", faults.STUCK, 900.0, 0.0, 0.0)
    record = cell_of(OBSERVER).run(demand_table(load("windshield_wiper"), 1.0), fault.applied(instruments(1)))
    assert np.flatnonzero(record["distrusted"])[0] - 900 < 600
    assert np.abs(record.error).max() < 2 * TOLERANCE


@pytest.mark.parametrize("plant_seed", [0, 8, 9])
def test_a_pad_switched_on_at_full_power_is_heat_and_no_fault(cell_of: CellOf, plant_seed: int) -> None:
    """60 W of which the law is not told, a warm-up after, with the model right and wrong."""
    demands = demand_table(load("windshield_wiper"), 1.0)
    still, padded = slice(1500, 3000), slice(1980, 3000)
    demands[still, :2] = 0.0
    demands[padded, 3:5] = PAD_TEMPERATURE, 273.15 + 47.0
    plant = mismatched(plant_seed)
    values = {**instruments(1), **{part: of_part(plant, part) for part in ("motor", "link")}}
    record = cell_of(OBSERVER).run(demands, values)
    assert record["distrusted"].mean() < 0.01
    assert np.abs(record.error).max() < TOLERANCE

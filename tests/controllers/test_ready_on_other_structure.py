"""Laws that no log taught, on machines of a structure that their model does not have."""

from functools import cache

import numpy as np
import pandas as pd
import pytest

from benchmarks.faults import rig, truth_of
from benchmarks.strange_machine import Demand, Machine, Room
from tests.shared_data import given
from warmlink.controllers.design.regression import fit_regression
from warmlink.controllers.design.structure import INSIDE, structure_spread
from warmlink.controllers.design.training import training_run
from warmlink.controllers.interface import SENSED
from warmlink.controllers.matrices import symmetric
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer_drift.component import COMPONENT as DRIFT
from warmlink.controllers.regression.component import COMPONENT as REGRESSION
from warmlink.controllers.replay import replay
from warmlink.fmus.component import Component
from warmlink.orchestration.replay.logs import MeasuredLog, read_logs

TOLERANCE = 5e-6

BASE, TIP = (SENSED.index(f"{place}_temperature") for place in ("base", "tip"))

LAWS = pytest.mark.parametrize("law", [REGRESSION, OBSERVER], ids=lambda law: law.name)


@cache
def logs() -> list[MeasuredLog]:
    """Two hours of light and heavier work of four machines, each in another hall."""
    demands = [Demand(2400, 1.0, 1.0), Demand(600), Demand(2400, 3.4, 2.5), Demand(1800)]
    rooms = (Room(), Room(mean=16.0, drift=0.5), Room(mean=29.0), Room(wander=0.3))
    frames: list[pd.DataFrame] = [
        Machine(50 + i).run(demands, 60 + i, room).log() for i, room in enumerate(rooms)
    ]
    return read_logs(frames)


def judged(law: Component, log: MeasuredLog) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Error in m, its stated standard deviation and `ready` after the first two minutes, without a camera."""
    inputs, _, acting = log.inputs_of(law, 1.0)
    told, late = replay(law, inputs), log.time - log.time[0] > 120.0
    late &= np.isfinite(log.reference_growth)
    at = acting[late]
    return log.reference_growth[late] - told.correction[at], told.correction_std[at], told.ready[at] > 0


@LAWS
def test_ready_is_true_on_machines_of_other_structure(law: Component) -> None:
    """It was wrong in a quarter of its time (observer), or all the time (regression), and is said still."""
    error, std, ready = (np.concatenate(each) for each in zip(*(judged(law, x) for x in logs()), strict=True))
    fine = np.abs(error) <= TOLERANCE
    assert not fine.all()
    assert np.mean(~fine[ready]) <= 0.02
    assert np.mean(ready[fine]) > 0.15
    assert np.mean(np.abs(error) <= 2 * std) > 0.9


@LAWS
def test_ready_is_true_on_a_given_machine(law: Component) -> None:
    log = read_logs([pd.read_parquet(given("machine/machine2_hot_restart.parquet"))])[0]
    error, std, ready = judged(law, log)
    assert np.mean(np.abs(error[ready]) > TOLERANCE) <= 0.02
    assert np.mean(np.abs(error) <= 2 * std) > 0.95


def test_what_a_camera_last_saw_of_the_error_counts_in_the_deviation_that_is_stated() -> None:
    """It learns slowly what no thermometer shows: errors were within two deviations in 74 % of the time."""
    log = logs()[0]
    inputs, measured, acting = log.inputs_of(DRIFT, 1.0)
    told, late = replay(DRIFT, inputs, measured), log.time - log.time[0] > 120.0
    error = (log.reference_growth - told.correction[acting])[late]
    assert np.mean(np.abs(error) <= 2 * told.correction_std[acting][late]) > 0.9


@pytest.mark.parametrize(
    ("duty", "least"), [("heavy_payload", 0.99), ("stop_and_go", 0.99), ("still_with_pad", 0.94)]
)
def test_thermometers_that_follow_the_model_show_that_the_machine_is_as_modelled(
    duty: str, least: float
) -> None:
    assert rig("observer").run(truth_of(duty, 0)).ready.mean() > least


def test_what_a_hall_makes_grow_no_heat_confirms() -> None:
    """It is ready there until the hall is some 5 K warmer than where growth is 0."""
    told = truth_of("rising_hall_temperature", 0)
    found = rig("observer").run(told)
    warm = told["ambient_temperature"] - told["ambient_temperature"][0]
    assert found.ready[warm < 3.0].mean() > 0.99
    assert not found.ready[warm > 6.0].any()


@pytest.mark.parametrize(("duty", "plant"), [("continuous", 32), ("windshield_wiper", 31)])
def test_a_machine_that_thermometers_contradict_may_grow_as_no_model_says(duty: str, plant: int) -> None:
    """Its gearbox may grow, and another flange bend the profile: no thermometer tells, so it is not ready."""
    outcome = rig("observer").run(truth_of(duty, plant))
    late = outcome.std[3600:]
    assert (late > 0.05 * outcome.elongation[3600:]).all()
    assert not outcome.ready[3600:].any()


def test_a_model_may_be_as_wrong_as_a_straight_line_would_make_it() -> None:
    """And what lies further in than the innermost thermometer may grow."""
    coefficients = np.zeros(len(SENSED))
    coefficients[BASE], coefficients[TIP] = 2e-6, 5e-6
    spread = symmetric(np.array(structure_spread(coefficients, [0.0, 0.0, 0.1, 0.0, 0.1], 7e-6)), len(SENSED))
    assert spread[TIP, TIP] == pytest.approx(1.5**2)
    assert spread[BASE, TIP] == pytest.approx(-(1.5**2))
    assert spread[BASE, BASE] == pytest.approx(1.5**2 + (7 * INSIDE) ** 2)
    assert not np.any(structure_spread(coefficients, [0.0] * 5, 7e-6))


def test_more_thermometers_leave_less_to_the_model() -> None:
    run = training_run()
    even = np.ones(len(SENSED))
    doubts = []
    for sensors in (("shaft",), ("base",), ("base", "tip"), ("base", "middle", "tip")):
        spread = symmetric(np.array(fit_regression(run, sensors)["coefficient_spread"]), len(SENSED))
        doubts.append(float(np.trace(spread)))
        assert even @ spread @ even >= 0.0
    assert min(doubts[:2]) > max(doubts[2:])

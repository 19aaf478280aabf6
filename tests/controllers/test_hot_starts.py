"""Laws that start with nothing to recall in a cell that was hot and has paused, with any thermometers."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.faults import learnt_values, rig
from benchmarks.law_trials import AS_MODELLED, mismatched
from benchmarks.told import Outcome, Told, bare_cell, truth
from warmlink.controllers.design.gains import design_controller
from warmlink.controllers.design.regression import fit_regression
from warmlink.controllers.design.training import training_run
from warmlink.controllers.interface import SENSED
from warmlink.controllers.start_values import by_scalar
from warmlink.fmus.duty_cycle.equations import DEMANDS

MINUTE, HOUR = 60, 3600

BOTH_ENDS = ("base", "tip")
ALL = ("shaft", "winding", "base", "middle", "tip")
SETS = (BOTH_ENDS, ("base", "middle", "tip"), ("shaft", "tip"), ("shaft", "base", "middle", "tip"), ALL)
"""Thermometers that suffice: they tell the whole link's temperature."""

LAWS = ("regression", "observer", "observer_drift")

slow = pytest.mark.slow


@cache
def after(pause: int, hot: int = 3 * HOUR, plant: int = 0, works: bool = True, seed: int = 1) -> Told:
    """What a law is told for the hour after so many s of work and of a pause, during which it was off."""
    off = mismatched(plant)
    demands = np.zeros((hot + pause + HOUR + 1, len(DEMANDS)))
    column = {name: i for i, name in enumerate(DEMANDS)}
    demands[:, column["ambient_temperature"]] = 295.15
    at_work = np.ones(len(demands), bool)
    at_work[hot : hot + pause] = False
    at_work[hot + pause :] = works
    demands[at_work, column["speed"]] = 3.43
    demands[at_work, column["torque"]] = 2.5
    cell = {name: off.given_of(name) for name in ("motor", "link")}
    told = truth(bare_cell(), demands, cell, 0.1, seed)
    return replace(told, rows=told.rows[hot + pause :])


@cache
def designed(law: str, sensors: tuple[str, ...]) -> Mapping[str, float]:
    if law == "analytic":
        return {"reference_temperature": 295.15}
    if law == "regression":
        return by_scalar(fit_regression(training_run(), sensors))
    return by_scalar(design_controller(law, sensors).parameters)


def started(law: str, sensors: tuple[str, ...], told: Told) -> Outcome:
    """The law in a cell of the model's structure: of another one it would say less."""
    return rig(law).run(replace(told, parameters={**designed(law, sensors), **_as_modelled(law)}))


@cache
def sound(law: str) -> Outcome:
    """The law after a minute, with all its readings."""
    return started(law, BOTH_ENDS, after(MINUTE))


def _as_modelled(law: str) -> Mapping[str, float]:
    return {} if law == "analytic" else AS_MODELLED


def within(found: Outcome, seconds: int, error: float = 5e-6) -> bool:
    return bool(np.abs(found.error[seconds:]).max() < error)


def leapt(found: Outcome, since: int, over: int = 10) -> float:
    """Largest change in m of the error in so many seconds."""
    error = found.error[since:]
    return float(np.abs(error[over:] - error[:-over]).max())


QUICK = [
    *((law, BOTH_ENDS, pause) for law in LAWS for pause in (MINUTE, 25 * MINUTE)),
    ("observer", ALL, MINUTE),
    ("observer", ALL, 25 * MINUTE),
    ("observer", ("base", "middle", "tip"), HOUR),
    ("observer_drift", ALL, HOUR),
]
PAUSES = (MINUTE, 10 * MINUTE, 25 * MINUTE, HOUR, 2 * HOUR, 12 * HOUR)
WIDE = [each for law in LAWS for s in SETS for p in PAUSES if (each := (law, s, p)) not in QUICK]
TABLE = [*QUICK, *(pytest.param(*each, marks=slow) for each in WIDE)]


@pytest.mark.parametrize(("law", "sensors", "pause"), TABLE)
def test_a_law_that_starts_in_a_hot_cell_is_within_tolerance_in_a_minute(
    law: str, sensors: tuple[str, ...], pause: int
) -> None:
    """After 25 min with the right model the observer was 50 um off for 1,600 s, and said 0.07 um."""
    found = started(law, sensors, after(pause))
    assert within(found, 60)
    assert leapt(found, 60) < 4e-6
    assert found.ready_wrong() == 0.0
    assert found.ready[180:].mean() > 0.75
    shown = np.abs(found.error) / found.std
    assert np.mean(shown < 2) > 0.8  # of one hour, in which errors are correlated
    assert shown.max() < 6


LEARNT = [
    *(("observer", BOTH_ENDS, pause) for pause in (MINUTE, 25 * MINUTE)),
    *(
        pytest.param(law, sensors, pause, marks=slow)
        for law in LAWS
        for sensors in (BOTH_ENDS, ALL, ("middle",))
        for pause in (MINUTE, 25 * MINUTE, 12 * HOUR)
    ),
]


@pytest.mark.parametrize(("law", "sensors", "pause"), LEARNT)
def test_so_is_a_law_that_a_log_taught(law: str, sensors: tuple[str, ...], pause: int) -> None:
    """Smoothed after the bounds that open for a hot cell, the observers shot past the growth by 18 um."""
    used = tuple(f"{place}_temperature" for place in sensors)
    found = rig(law).run(replace(after(pause), parameters=learnt_values(law, 0, used)))
    assert within(found, 60)
    assert found.ready_wrong() == 0.0
    assert found.ready[180:].mean() > 0.75


@pytest.mark.parametrize("pause", [MINUTE, pytest.param(10 * MINUTE, marks=slow), 25 * MINUTE])
@pytest.mark.parametrize("hot", [15 * MINUTE, pytest.param(30 * MINUTE, marks=slow)])
@pytest.mark.parametrize("works", [True, False])
def test_it_need_not_have_been_hot_for_long_nor_work_again(hot: int, pause: int, works: bool) -> None:
    assert within(started("observer", BOTH_ENDS, after(pause, hot, works=works)), 60)


@slow
@pytest.mark.parametrize("plant", [1, 2, 3, 4, 31, 7018])
@pytest.mark.parametrize("pause", [MINUTE, 25 * MINUTE])
@pytest.mark.parametrize("sensors", [BOTH_ENDS, ALL])
def test_a_wrong_model_needs_no_longer(plant: int, pause: int, sensors: tuple[str, ...]) -> None:
    """121 um, which plant 31 has grown by, take a minute at the largest rate; what is left is the model's."""
    found = started("observer", sensors, after(pause, plant=plant))
    assert within(found, 75, max(5e-6, 0.06 * found.elongation.max()))


@pytest.mark.parametrize("by", [1.0, 2.0, 5.0, 20.0])
@pytest.mark.parametrize("sensors", [BOTH_ENDS, pytest.param(ALL, marks=slow)])
def test_a_cold_cell_whose_thermometers_are_all_off_is_not_taken_for_a_hot_one(
    by: float, sensors: tuple[str, ...]
) -> None:
    told = after(24 * HOUR)
    for name in SENSED:
        told = told.changed(name, told[name] + by)
    found = started("observer", sensors, told)
    assert found.worse_by <= 5e-6
    assert found.ready_wrong() <= 1e-3


def test_what_a_bound_holds_back_counts_in_the_deviation_that_is_stated() -> None:
    """It was 50 um off and stated 0.07 um."""
    found = started("observer", BOTH_ENDS, after(25 * MINUTE))
    early = slice(0, 30)
    assert (np.abs(found.error[early]) < 2 * found.std[early]).all()


@pytest.mark.parametrize("wrong", [295.15, 0.0, 1e20, np.nan])
@pytest.mark.parametrize("when", [0, 4])
@pytest.mark.parametrize("law", ["analytic", *LAWS])
def test_one_wrong_first_reading_costs_no_more_than_seconds(law: str, wrong: float, when: int) -> None:
    """A reading of 22 degC at the start cost three hours: the regression 107 um, the observers 20 um."""
    told = after(MINUTE)
    for name in SENSED:
        told = told.changed(name, wrong, slice(when, when + 1))
    found, ideal = started(law, BOTH_ENDS, told), sound(law)
    late = slice(90, None)
    assert np.abs(found.correction[late] - ideal.correction[late]).max() < 1e-6 + (law == "analytic") * 4e-6


@pytest.mark.parametrize("law", ["observer", "observer_drift"])
def test_a_hall_thermometer_that_is_off_and_heat_of_a_brake_make_no_leap(law: str) -> None:
    """0.6 K too low, and 5 W beside the motor's: it was 20 um off for hours, and leapt by 12 um."""
    draw = np.random.default_rng(104)
    demands = np.zeros((2 * HOUR, len(DEMANDS)))
    column = {name: i for i, name in enumerate(DEMANDS)}
    demands[:, column["ambient_temperature"]] = 295.15
    first = 0
    while first < len(demands):
        last = first + int(draw.uniform(120, 1800))
        work = draw.random() < 0.7
        demands[first:last, column["speed"]] = work * draw.uniform(0.5, 4.0)
        demands[first:last, column["torque"]] = work * draw.uniform(0.5, 3.5)
        first = last
    demands[:, column["pad_mode"]], demands[:, column["pad_power"]] = 1.0, 5.0
    told = truth(bare_cell(), demands, {}, 0.1, 104)
    found = rig(law).run(told.changed("ambient_temperature", 294.55))
    assert np.abs(found.error).max() < 5e-6
    assert leapt(found, 0) < 2.5e-6
    assert found.ready_wrong() == 0.0

from dataclasses import replace

import numpy as np
import pytest

from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.studies.case import METRICS, Outcome, case_of, warm_up_first
from warmlink.orchestration.written.expression import Expression


def test_warming_up_first_gives_what_is_left_after_the_growth_has_settled() -> None:
    time = np.arange(0, 7201.0)
    growth = 50e-6 * (1 - np.exp(-time / 1000))
    # Zero set at t, the rest grows by 50 um exp(-t/1000), which is 5 um from 1000 s ln 10 = 2303 s on.
    assert warm_up_first(time, growth, 5e-6) == pytest.approx((7200 - 1000 * np.log(10)) / 60, abs=1.0)


def test_warming_up_first_gives_everything_where_nothing_grows() -> None:
    time = np.arange(0, 601.0)
    assert warm_up_first(time, np.zeros(601), 5e-6) == 10.0


def test_minutes_between_two_levels_count_once() -> None:
    time = np.arange(0, 3601.0)
    growth = np.where((time // 600) % 2 == 0, 0.0, 30e-6)
    # Half of the hour is at either level, and a zero set at once makes use of one of them.
    assert warm_up_first(time, growth, 5e-6) == pytest.approx(30, abs=0.5)


def test_a_run_whose_roles_differ_is_another_run() -> None:
    """Its figures come of them, so that those kept before are not its own."""
    scenario = load_scenario("stop_and_go")
    half = Expression("0.5 * link.elongation")
    changed = [{"score": half}, {"uncompensated": half}, {"plant": ("motor.shaft_temperature",)}]
    machines = [replace(scenario.machine, roles=replace(scenario.machine.roles, **each)) for each in changed]
    runs = [case_of(replace(scenario, machine=each), ("lag",)) for each in (scenario.machine, *machines)]
    assert len({run.digest for run in runs}) == len(runs)


@pytest.mark.parametrize("step", [1.0, 20.0, 60.0])
def test_the_end_of_a_warm_up_is_sought_on_a_grid_of_a_minute_whatever_the_step(step: float) -> None:
    time = np.arange(0, 7201.0, step)
    growth = np.where(time < 60.0, 0.0, np.where(time < 1020.0, 30e-6, 60e-6))
    assert warm_up_first(time, growth, 5e-6) == 103.0  # from 1020 s on, which is the 17th minute


def test_a_run_that_stopped_has_no_time_to_tolerance() -> None:
    case = case_of(load_scenario("stop_and_go"), ("lag",))
    assert np.isnan(METRICS["time_to_tolerance_s"](Outcome(stopped="the motor is too hot"), case))
    assert METRICS["time_to_tolerance_s"](Outcome(), case) == case.stop_time

from dataclasses import replace

import numpy as np

from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.studies.case import METRICS, Outcome, case_of
from warmlink.orchestration.written.expression import Expression


def test_a_run_whose_roles_differ_is_another_run() -> None:
    """Its figures come of them, so that those kept before are not its own."""
    scenario = load_scenario("stop_and_go")
    half = Expression("0.5 * link.elongation")
    changed = [{"score": half}, {"uncompensated": half}, {"plant": ("motor.shaft_temperature",)}]
    machines = [replace(scenario.machine, roles=replace(scenario.machine.roles, **each)) for each in changed]
    runs = [case_of(replace(scenario, machine=each), ("lag",)) for each in (scenario.machine, *machines)]
    assert len({run.digest for run in runs}) == len(runs)


def test_a_run_that_stopped_has_no_time_to_tolerance() -> None:
    case = case_of(load_scenario("stop_and_go"), ("lag",))
    assert np.isnan(METRICS["time_to_tolerance_s"](Outcome(stopped="the motor is too hot"), case))
    assert METRICS["time_to_tolerance_s"](Outcome(), case) == case.stop_time

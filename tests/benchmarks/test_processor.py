"""An exported law as the controller of the closed loop, on processors that qemu emulates."""

from dataclasses import replace

import pytest

from benchmarks.processor.__main__ import closed_loop
from benchmarks.processor.board import TARGETS, Target, missing_tools
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.scenarios.scenario import changed

pytestmark = [
    pytest.mark.platform,
    pytest.mark.skipif(missing_tools() is not None, reason=str(missing_tools())),
]


@pytest.mark.parametrize("target", TARGETS, ids=lambda each: each.name)
def test_the_observer_is_the_controller_of_the_closed_loop(target: Target) -> None:
    scenario = changed(load_scenario("windshield_wiper"), "observer", mismatches=["noisy_sensors"])
    found = closed_loop(replace(scenario, duty=scenario.duty.until(300.0)), target)
    assert found.largest > 0.01e-6, "the loop is closed through sensors that are wrong"
    assert found.lost < {"double": 1e-9 * 14e-6, "single": 0.05e-6}[target.precision]
    assert abs(found.largest - found.largest_fmu) <= found.lost
    assert 1_000 < found.cost.instructions < 60_000
    assert 1_000 < found.code < 96 * 1024
    assert 100 < found.cost.struct < found.cost.stack < 64 * 1024

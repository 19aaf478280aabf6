"""What may begin to be wrong, of machines with values of their own."""

from __future__ import annotations

from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.watch.hypotheses import watched

INPUTS, SHAFT = ("motor.torque", "motor.ambient_temperature"), "motor.shaft_temperature"


def test_a_cause_that_is_a_share_of_nothing_is_none() -> None:
    """A machine without a joint has no loose one; it would have no span, and all that is learnt no number."""
    rig = rig_of("WarmupCell")
    for conductance, has_one in ((0.0, False), (1.0, True)):
        machine = watched(rig, {"motor.joint_conductance": conductance}, INPUTS, [SHAFT], {SHAFT: "shaft"})
        assert all(each.span > 0 for each in machine.hypotheses)
        assert any("motor.joint_conductance" in each.cause.frees for each in machine.hypotheses) is has_one

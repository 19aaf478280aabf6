"""A thermal resistance in the joint."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="joint_resistance",
    sentence="Heat passes from shaft to link with more resistance than assumed.",
    frees=("motor.joint_resistance",),
    lower=0.0,
    upper=10.0,
    shown_unit="K/W",
    looks_like="shaft warmer and link cooler than simulated",
    check="Check the clamping screws and whether the contact faces are clean, flat and greased.",
)

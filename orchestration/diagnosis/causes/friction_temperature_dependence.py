"""Friction that falls with warmth."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="friction_temperature_dependence",
    sentence="Friction falls (or rises) as the gear warms.",
    frees=("motor.friction_temperature_coefficient",),
    lower=-0.05,
    upper=0.05,
    shown_unit="1/K",
    looks_like="right while cold, wrong while warm and moving",
    check="Compare the unloaded current cold and warm; check the grease's grade.",
)

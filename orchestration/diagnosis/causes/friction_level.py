"""Another friction."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="friction_level",
    sentence="Bearings and gear make more or less friction heat than assumed.",
    frees=("motor.friction_factor",),
    lower=0.0,
    upper=4.0,
    neutral=1.0,
    shown_unit="1",
    looks_like="wrong while moving, in proportion to speed, shaft before winding",
    check="Run the joint unloaded at constant speed and read the current; check grease and preload.",
)

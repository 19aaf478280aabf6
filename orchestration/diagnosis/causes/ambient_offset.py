"""A wrong ambient temperature."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="ambient_offset",
    sentence="The real surroundings are warmer or colder than logged.",
    frees=("motor.ambient_offset", "link.ambient_offset"),
    lower=-15.0,
    upper=15.0,
    shown_unit="K",
    looks_like="everything drifts to another level, even at rest",
    check="Put a second thermometer beside the machine; check where the logged one hangs.",
)

"""Surroundings that warm or cool unlogged."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="ambient_drift",
    sentence="The surroundings warm or cool during the run, and the log does not show it.",
    frees=("motor.ambient_drift", "link.ambient_drift"),
    lower=-0.004166666666666667,
    upper=0.004166666666666667,
    shown_unit="K/h",
    looks_like="an error that grows with time, at rest too",
    check="Log the room's temperature beside the machine; think of sun, doors and other machines.",
)

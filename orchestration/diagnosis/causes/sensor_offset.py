"""A sensor that reads too high or low."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="sensor_offset",
    sentence="The reading is off by a constant.",
    frees=("offset",),
    lower=-10.0,
    upper=10.0,
    kind="reading",
    looks_like="a constant error from the first row on",
    check="Compare the readings with everything at rest, cold.",
)

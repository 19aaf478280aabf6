"""A shifted clock."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="clock_offset",
    sentence="The measured columns are stamped late or early against the commands.",
    frees=("record.clock_offset",),
    lower=-600.0,
    upper=600.0,
    shown_unit="s",
    kind="record",
    looks_like="every measured change comes late or early by one and the same time",
    check="Compare the clocks of the controller and of the logger.",
)

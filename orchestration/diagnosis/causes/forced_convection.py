"""Another loss to air by movement."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="forced_convection",
    sentence="Moving cools the link more or less than assumed.",
    frees=("link.convection_per_speed",),
    lower=0.0,
    upper=4.0,
    relative=True,
    shown_unit="W.s/(m3.K)",
    looks_like="right while still, wrong while moving, in proportion to speed",
    check="Compare the real path with the mean speed in the log; look for covers on the link.",
)

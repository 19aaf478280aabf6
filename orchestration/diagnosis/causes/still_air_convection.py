"""Another loss to still air."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="still_air_convection",
    sentence="The link loses more or less heat to still air than assumed.",
    frees=("link.convection_still",),
    lower=0.2,
    upper=4.0,
    relative=True,
    shown_unit="W/(m2.K)",
    looks_like="the link settles cooler or warmer than simulated, moving or not",
    check="Look for draughts, fans, covers and hoses around the link.",
)

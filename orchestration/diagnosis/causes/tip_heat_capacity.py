"""Something heavy at the tip."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="tip_heat_capacity",
    sentence="Something at the tip stores heat: a gripper or tool that the model leaves out.",
    frees=("link.tip_heat_capacity",),
    lower=0.0,
    upper=2000.0,
    shown_unit="J/K",
    looks_like="the tip follows late, and settles rightly",
    check="Weigh what is mounted at the tip.",
)

"""Heat lost at the tip."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="tip_heat_loss",
    sentence="Heat leaves at the tip, through a gripper, a tool or a cooled part.",
    frees=("link.tip_conductance",),
    lower=0.0,
    upper=2.0,
    shown_unit="W/K",
    looks_like="the tip stays cooler than simulated",
    check="Feel whether the tool is warm; look for coolant and for metal contact beyond the tip.",
)

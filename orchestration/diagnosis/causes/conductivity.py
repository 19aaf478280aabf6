"""Another conductivity of the link."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="conductivity",
    sentence="The link conducts heat better or worse than its data sheet says.",
    frees=("link.conductivity",),
    lower=0.3,
    upper=2.0,
    relative=True,
    shown_unit="W/(m.K)",
    looks_like="base and tip differ by more or less than simulated",
    check="Check the alloy and temper of the link, and whether it is hollow or jointed.",
    material=True,
)

"""Another coefficient of expansion."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="expansion_coefficient",
    sentence="The link grows more or less a kelvin than its data sheet says.",
    frees=("link.expansion_coefficient",),
    lower=0.5,
    upper=1.5,
    relative=True,
    shown_unit="1/K",
    looks_like="temperatures right, elongation wrong by a constant factor",
    check="Check the alloy; an independent length gauge tells it from a wrong scale of the camera.",
    material=True,
)

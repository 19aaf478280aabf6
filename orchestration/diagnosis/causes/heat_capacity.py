"""Another heat capacity of the link."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="heat_capacity",
    sentence="The link stores more or less heat than assumed.",
    frees=("link.specific_heat",),
    lower=0.5,
    upper=2.0,
    relative=True,
    shown_unit="J/(kg.K)",
    looks_like="warms and cools too fast or too slowly, but settles rightly",
    check="Weigh the link; look for cables, hoses and brackets fixed to it.",
    material=True,
)

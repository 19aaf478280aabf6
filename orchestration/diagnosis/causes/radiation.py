"""Heat radiated by the link's surface."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="radiation",
    sentence="The link's surface radiates heat, which the model leaves out.",
    frees=("link.emissivity",),
    lower=0.0,
    upper=1.0,
    shown_unit="1",
    looks_like="the link is cooler than simulated, the more so the hotter it is",
    check="Look at the surface: paint and anodising radiate strongly, bare metal hardly.",
)

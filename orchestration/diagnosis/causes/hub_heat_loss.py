"""Heat lost at the hub."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="hub_heat_loss",
    sentence="Heat leaves the link at its base before it travels outward.",
    frees=("link.hub_conductance",),
    lower=0.0,
    upper=5.0,
    shown_unit="W/K",
    looks_like="base and everything beyond it cooler than simulated",
    check="Look for metal contact, a fan or a cooled housing near the hub.",
)

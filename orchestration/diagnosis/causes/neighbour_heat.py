"""Heat from the neighbouring joint."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="neighbour_heat",
    sentence="Heat comes from or goes to the neighbouring joint.",
    frees=("motor.neighbour_conductance",),
    lower=0.0,
    upper=10.0,
    shown_unit="W/K",
    covariate="neighbour_temperature",
    looks_like="follows the neighbour's temperature",
    check="Warm the neighbouring joint alone and watch this one.",
)

"""Heat radiated onto the link."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="radiant_heating",
    sentence="The link is heated from outside: sun, lamps or a hot neighbour.",
    frees=("link.absorbed_flux",),
    lower=-200.0,
    upper=1000.0,
    shown_unit="W/m2",
    looks_like="the whole link warmer than simulated, even before the motor runs",
    check="Shade the link and watch; look for lamps, ovens and windows.",
)

"""Conductivity that changes with temperature."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="conductivity_temperature_dependence",
    sentence="The link's conductivity changes with temperature.",
    frees=("link.conductivity_temperature_coefficient",),
    lower=-0.005,
    upper=0.005,
    shown_unit="1/K",
    looks_like="the gradient along the link is right while cold and wrong while hot",
    check="Compare the alloy's conductivity at 20 and 60 degC.",
    material=True,
)

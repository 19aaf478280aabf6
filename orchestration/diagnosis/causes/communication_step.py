"""An artefact of the simulation itself."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="communication_step",
    sentence="The simulation's steps are too coarse: its error looks like an effect.",
    frees=("simulation.communication_step",),
    lower=0.0,
    upper=600.0,
    shown_unit="s",
    kind="simulation",
    looks_like="an error after every change of the inputs, which shrinks with the step",
    check="Halve the communication step of the co-simulation and compare.",
)

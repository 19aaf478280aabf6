"""No compensation, as a component."""

from __future__ import annotations

from warmlink.controllers.interface import INPUTS, OUTPUTS, TERMINALS, TOLERANCE
from warmlink.controllers.none import law
from warmlink.fmus.component import Component, Parameter

COMPONENT = Component(
    name="NoCompensator",
    description="No compensation",
    inputs=INPUTS,
    terminals=TERMINALS,
    parameters=(
        TOLERANCE,
        Parameter(
            "elongation_std",
            "m",
            5e-5,
            "standard deviation of the growth, which stays uncorrected",
            display="um",
            minimum=0,
            nominal=5e-5,
        ),
    ),
    outputs=OUTPUTS,
    observe=law.outputs,
)

"""Another copper loss."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="copper_loss",
    sentence="The winding makes more or less heat from its current than assumed.",
    frees=("motor.winding_resistance",),
    lower=0.2,
    upper=4.0,
    relative=True,
    shown_unit="Ohm",
    looks_like="wrong in proportion to torque squared, the winding first",
    check="Measure the winding's resistance; check the torque constant and how the log forms its rms.",
)

"""A wrong scale of the measured elongation."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="elongation_scale",
    sentence="The measured elongation is off by a constant factor.",
    frees=("scale",),
    lower=0.5,
    upper=1.5,
    neutral=1.0,
    shown_unit="1",
    kind="camera",
    looks_like="temperatures right, elongation wrong by a constant factor",
    check="Calibrate the camera or gauge with a step of known size.",
)

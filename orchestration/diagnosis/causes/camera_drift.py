"""A drifting camera."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="camera_drift",
    sentence="The camera or gauge drifts steadily as it warms or creeps.",
    frees=("drift_rate",),
    lower=-2.777777777777778e-08,
    upper=2.777777777777778e-08,
    shown_unit="um/h",
    kind="camera",
    looks_like="temperatures right, elongation off by a steady ramp",
    check="Watch a fixed mark with the camera for an hour.",
)

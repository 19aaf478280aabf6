"""A slow sensor."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="sensor_lag",
    sentence="The sensor follows late: a first-order lag.",
    frees=("lag",),
    lower=0.0,
    upper=900.0,
    shown_unit="s",
    kind="temperature sensor",
    looks_like="wrong while temperatures change, right when settled",
    check="Check thermal paste and fixing of the sensor; exchange it with another.",
)

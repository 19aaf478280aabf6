"""A sensor cooled by its stem."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="sensor_stem_conduction",
    sentence="The sensor's stem or cable conducts heat away, so that it reads too near the ambient.",
    frees=("stem_conduction",),
    lower=0.0,
    upper=0.8,
    shown_unit="1",
    kind="temperature sensor",
    looks_like="an error in proportion to the rise above ambient, from one sensor alone",
    check="Insulate the sensor and lay its cable along the surface; read again.",
)

"""Heat at standstill."""

from warmlink.orchestration.diagnosis.cause import Cause

CAUSE = Cause(
    name="standby_heat",
    sentence="The drive makes heat even at standstill: brake, holding current or electronics.",
    frees=("motor.standby_power",),
    lower=0.0,
    upper=60.0,
    shown_unit="W",
    looks_like="warms although nothing moves",
    check="Switch the drive on without moving and watch the shaft; measure its standby power.",
)

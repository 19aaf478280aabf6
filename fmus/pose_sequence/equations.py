"""Poses one after another, each held for a time: a function of time alone, as the duty cycle is."""

from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, stack, total
from warmlink.fmus.duty_cycle.equations import SEGMENTS, active_segment, derive

POSES = SEGMENTS
AXES = 6

__all__ = ["AXES", "POSES", "derive", "outputs"]


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Angle in rad of each joint: those of the pose that has begun by then."""
    active = active_segment(p, time)
    angles = (getattr(p, f"joint_{axis}") for axis in range(1, AXES + 1))
    return {"angle": stack(*(total(active * each) for each in angles))}

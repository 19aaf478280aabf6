"""A duty cycle: constant demands over segments of time, a function of time alone."""

from __future__ import annotations

from collections.abc import Mapping

from warmlink.fmus.component import Record
from warmlink.fmus.component.arithmetic import LARGEST, Number, floor, maximum, stack, total, where

SEGMENTS = 32

EARLY = 1e-6
"""s by which rounding, also that of a master that adds its steps up, may miss a segment's beginning."""

LONGEST = 1e8
"""s, three years, that a segment may last; the ends of 32 such are still told apart to a microsecond."""

DEMANDS = ("speed", "torque", "ambient_temperature", "pad_mode", "pad_temperature", "pad_power")
"""What a segment holds; the parameter of each bears `segment_` before its name."""


def derive(p: Record) -> Mapping[str, Number]:
    """Times in s at which each segment begins and gives way; the last one in use never does."""
    ends = [p.duration[0]]
    for i in range(1, SEGMENTS):
        ends.append(ends[-1] + p.duration[i])
    begins = [0.0, *ends[:-1]]
    length = ends[-1]
    until = [where(end >= length, LARGEST, end) for end in ends]
    until = [where(p.duration[i] > 0, until[i], begins[i]) for i in range(SEGMENTS)]
    return {"segment_begin": stack(*begins), "segment_until": stack(*until), "length": length}


def outputs(x: Record, u: Record, p: Record, time: Number) -> Mapping[str, Number]:
    """Demands at a time: of the segment that has begun by then."""
    active = active_segment(p, time)
    return {name: total(active * getattr(p, f"segment_{name}")) for name in DEMANDS}


def active_segment(p: Record, time: Number) -> Number:
    """One at the segment that a time in s falls in and zero at the others, shape (32,)."""
    now = maximum(time, 0.0) + EARLY
    rounds = where(p.repeat > 0.5, floor(now / p.length), 0.0)
    into = now - rounds * p.length
    begun = where(p.segment_begin <= into, 1.0, 0.0)
    return begun * where(into < p.segment_until, 1.0, 0.0)

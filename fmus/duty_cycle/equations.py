"""A duty cycle: constant demands over segments of time, a function of time alone."""

from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import LARGEST, Number, floor, maximum, stack, total, where
from warmlink.fmus.component.quantities import DUTY
from warmlink.fmus.component.table import EARLY

SEGMENTS = 32

LONGEST = 1e8
"""s, three years, that a segment may last; the ends of 32 such are still told apart to a microsecond."""

DEMANDS = tuple(demand.name for demand in DUTY)
"""What a segment holds; the parameter of each bears `segment_` before its name."""


def derive(p: Record) -> Values:
    """Times in s at which each segment begins; those after the last one in use never do."""
    begins: list[Number] = [0.0]
    for i in range(SEGMENTS):
        begins.append(begins[-1] + p.duration[i])
    length = begins.pop()
    return {
        "segment_begin": stack(*(where(begin >= length, LARGEST, begin) for begin in begins)),
        "length": length,
    }


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Demands at a time: of the segment that has begun by then."""
    active = active_segment(p, time)
    return {name: total(active * getattr(p, f"segment_{name}")) for name in DEMANDS}


def active_segment(p: Record, time: Number) -> Number:
    """One at the segment that a time in s falls in and zero at the others, shape (32,)."""
    now = maximum(time, 0.0) + EARLY
    rounds = where(p.repeat > 0.5, floor(now / p.length), 0.0)
    # A comparison counts as one or zero, and a product with it costs a processor less than a choice.
    begun = 1.0 * (p.segment_begin <= now - rounds * p.length)
    return begun - stack(begun[1:], 0.0)

"""Leaps of thermometers: no heat changes a temperature so fast, so that one of two readings was wrong.

Which one is not known. What a thermometer has leapt is added up; until it leaps back a law is not ready.
"""

from warmlink.controllers.fail_safe import FASTEST, Trust
from warmlink.controllers.interface import SENSED
from warmlink.fmus.calls import as_c_function
from warmlink.fmus.component import Record, State, Values
from warmlink.fmus.component.arithmetic import Number, absolute, finite, maximum, total, truth, where

STATES = (State("leapt", "K", size=len(SENSED)), State("silent_for", "s", size=len(SENSED)))
"""By how much each thermometer has leapt, and for how long it has told nothing."""


def none(readings: Number) -> Values:
    """The states at the start."""
    zero = where(finite(readings), 0.0 * readings, 0.0)
    return {"leapt": zero, "silent_for": zero}


def later(x: Record, readings: Number, before: Trust, p: Record, step: Number) -> Values:
    """The states after a sample, beside what was remembered of the readings before it."""
    leapt, silent_for = _later(x.leapt, x.silent_for, readings, before.last, before.out, p, step)
    return {"leapt": leapt, "silent_for": silent_for}


def leapt(x: Record) -> Number:
    """1 where a thermometer has leapt and not leapt back, else 0."""
    return truth(total(absolute(x.leapt)) > 0)


@as_c_function
def _later(
    leapt: Number,
    silent_for: Number,
    readings: Number,
    last: Number,
    out: Number,
    p: Record,
    step: Number,
) -> tuple[Number, Number]:
    there, silent_for = truth(finite(readings)), silent_for + step
    change, noise = readings - last, 2.0**0.5 * p.gate * p.sensor_std
    used = truth(p.sensor_std > 0) * there * truth(finite(last))
    # What is left out without a leap may return from wherever it was; what has leapt may leap on, and back.
    counts = maximum(1.0 - out, truth(absolute(leapt) > 0))
    fast = truth(absolute(change) > noise + FASTEST * silent_for) * counts
    after = leapt + where(used * fast > 0, change, 0.0)
    return where(absolute(after) > noise, after, 0.0), where(there > 0, 0.0, silent_for)

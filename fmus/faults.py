"""Faults of measuring instruments, shared by all components that measure.

From the time of a fault on, a reading sticks, jumps, drifts away, or drops out as NaN.
"""

import math
from functools import partial

from warmlink.fmus.component import Choice, Parameter
from warmlink.fmus.component.arithmetic import Number, where
from warmlink.fmus.component.quantities import tunable

STUCK, JUMP, DRIFT, DROPOUT = 1, 2, 3, 4
"""Values of a fault kind besides 0, none."""

FAULT_KIND = Choice("FaultKind", ("none", "stuck", "jump", "drift", "dropout"))

_EARLY = -1e-9
"""Tolerance in s: a sample that rounding puts this little before a fault already has the fault."""


def parameters(
    unit: str, display: str, jump: float, drift: float, size: int | None = None
) -> tuple[Parameter, ...]:
    """Parameters that give an instrument of one or several channels its faults.

    The units are those of what is measured, in SI and as people read it; jump and drift (per second) are
    ordinary sizes in the SI unit.
    """
    shown = None if display == unit else display
    each = partial(tunable, size=size)
    kinds = "fault: 0 none, 1 stuck, 2 jump, 3 drift, 4 dropout (NaN)"
    added = "error that a drift adds per second (fault 3)"
    return (
        each("fault_kind", "1", 0, kinds, choice=FAULT_KIND),
        each("fault_time", "s", 0, "simulation time at which the fault begins", nominal=3600),
        each("fault_size", unit, 0, "what a jump adds (fault 2)", display=shown, nominal=jump),
        each("fault_rate", f"{unit}/s", 0, added, display=f"{display}/h", nominal=drift),
    )


def shift(kind: Number, size: Number, rate: Number, since: Number) -> Number:
    """Error that a fault adds to a measured value, in the value's unit.

    That is the size of a jump, or the rate of a drift per second times the s since the fault began, which are
    negative before it. All may be vectors.
    """
    added = where(kind == JUMP, size, where(kind == DRIFT, rate * since, 0.0))
    return where(since >= _EARLY, added, 0.0)


def replaced(value: Number, last: Number, kind: Number, since: Number) -> Number:
    """Reading with a fault: the last one if it is stuck, NaN if it dropped out."""
    broken = where(kind == STUCK, last, where(kind == DROPOUT, math.nan, value))
    return where(since >= _EARLY, broken, value)

"""No correction at all."""

from warmlink.controllers.interface import ready
from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """No correction in m, and the size of the growth that it leaves."""
    return {
        "correction": 0.0,
        "predicted_elongation": 0.0,
        "correction_std": p.elongation_std,
        "ready": ready(p.elongation_std, p.tolerance),
        "distrusted": 0.0,
        "warning": 0.0,
    }

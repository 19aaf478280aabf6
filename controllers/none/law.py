"""No correction at all."""

from warmlink.controllers.interface import law_outputs
from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """No correction in m, and the size of the growth that it leaves."""
    return law_outputs(0.0, p.elongation_std, p)

"""A table over time: each column holds until the next row, or goes there in a straight line."""

from __future__ import annotations

from collections.abc import Sequence

from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number
from warmlink.fmus.component.table import table_row, values_at


def derive(p: Record) -> Values:
    """Place of the number that stands for the table, which whoever runs the component fills in."""
    return {"rows": 0.0}


def outputs(x: Record, u: Record, p: Record, time: Number, names: Sequence[str]) -> Values:
    """Values at a time, by the columns' names."""
    values = values_at(table_row(p.rows, time, len(names)), time, len(names))
    return {name: values[i] for i, name in enumerate(names)}

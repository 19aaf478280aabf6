"""The recorded duty as a component, and players of any other table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

from numpy.typing import ArrayLike

from warmlink.fmus.component import Component, Derived, Output, Terminal
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE, bus
from warmlink.fmus.component.table import Played, RecordedTable
from warmlink.fmus.duty_cycle.component import COMPONENT as DUTY_CYCLE
from warmlink.fmus.recorded_duty import equations

LOWEST_TEMPERATURE = 1e-3
"""K, below which nothing is."""


def player(
    name: str,
    description: str,
    outputs: Sequence[Output],
    table: RecordedTable,
    terminals: tuple[Terminal, ...] = (),
) -> Component:
    """Declare a component that plays a table.

    Parameters
    ----------
    name : name of the component, an identifier, as `RecordedDuty`
    description : one line
    outputs : what is played, single numbers; the table has a column of the name of each, in this order
    table : times in s, and values in SI units
    terminals : which outputs belong together

    Raises
    ------
    InputError
        If the table has other columns, or values out of an output's range.
    """
    # Discrete: they jump from row to row, so that no master may interpolate them over a step.
    jumping = tuple(replace(each, discrete=True) for each in outputs)
    return Component(
        name=name,
        description=description,
        derived=(Derived("rows", "1"),),
        outputs=jumping,
        terminals=terminals,
        derive=equations.derive,
        observe=partial(equations.outputs, names=[each.name for each in jumping]),
        tables=(Played("rows", jumping, table),),
    )


def playing(component: Component, table: RecordedTable) -> Component:
    """The component that plays another table in place of its own; raises as `player`."""
    (played,) = component.tables
    return replace(component, tables=(replace(played, table=table),))


def _bounded(demand: Output) -> Output:
    """A demand with the range that a segment of a duty cycle has."""
    if demand.choice is not None:
        return demand
    return replace(demand, minimum=LOWEST_TEMPERATURE if demand.display == "degC" else 0.0)


_DEMANDS = tuple(map(_bounded, DUTY_CYCLE.outputs))

_SHIPPED = {"speed": 3.43, "torque": 2.5}
"""What the shipped table demands, whose one row holds for ever."""


def duty_table(
    times: ArrayLike, columns: Mapping[str, ArrayLike], linear: Sequence[str] = ()
) -> RecordedTable:
    """Table of a duty from some of its columns; the others are 0, or 22 degC, with the pad off."""
    usual = {d.name: ROOM_TEMPERATURE if d.display == "degC" else 0.0 for d in _DEMANDS}
    return RecordedTable(times, {name: columns.get(name, [value]) for name, value in usual.items()}, linear)


COMPONENT = player(
    "RecordedDuty",
    "Recorded duty: a table of any length, each column held or linear between its rows",
    _DEMANDS,
    duty_table([0.0], {name: [value] for name, value in _SHIPPED.items()}),
    terminals=(bus("duty", "Duty", *(demand.name for demand in _DEMANDS)),),
)

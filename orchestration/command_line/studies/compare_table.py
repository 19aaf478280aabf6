"""The table of a comparison on the terminal."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from warmlink.orchestration.scenarios.mismatch import NOMINAL
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER
from warmlink.orchestration.studies.compare import Comparison, Row

if TYPE_CHECKING:
    from rich.table import Table

BEST, BEYOND, HARM = "*", "!", "!!"
LEGEND = (
    f"{BEST} best in its row, or equal to it within the error budget   {BEYOND} beyond tolerance   "
    f"{HARM} worse than no compensation"
)
WIDE = 240
"""Width in characters where the output is not a terminal."""


def print_table(comparison: Comparison) -> None:
    """Print the table and what its marks mean."""
    from rich.console import Console

    console = Console() if sys.stdout.isatty() else Console(width=WIDE)
    console.print(table(comparison))
    console.print(LEGEND, highlight=False, markup=False)


def table(comparison: Comparison) -> Table:
    """Largest error in um and the share removed: a row for each duty cycle, a column for each controller."""
    from rich.table import Table

    shown = Table(title="largest error in µm, and the share of it removed", title_justify="left", box=None)
    shown.add_column("")
    for name in comparison.controllers:
        shown.add_column(name, justify="right", no_wrap=True)
    if NOMINAL in comparison.mismatches:
        _section(shown, comparison, NOMINAL, [NOMINAL])
    others = [name for name in comparison.mismatches if name != NOMINAL]
    if others:
        heading = others[0] if len(others) == 1 else f"worst of {len(others)} mismatches"
        _section(shown, comparison, heading, others)
    _minutes(shown, comparison)
    return shown


def cell(row: Row, best_um: float) -> str:
    """Figures of one run with their marks; `best_um` is the smallest largest error of its row."""
    if row.outcome.stopped is not None:
        return f"stopped {HARM:<3}"
    error = f"{row.outcome.max_abs_um:.1f}"
    if row.controller == NO_CONTROLLER:
        return error
    removed = "" if row.removed_percent is None else f"{row.removed_percent:.0f} %"
    mark = HARM if row.worse_than_none else BEYOND if row.beyond_tolerance else ""
    equal = row.outcome.max_abs_um - best_um <= (row.equal_within_um or 0.0)
    return f"{error} {removed:>5} {mark + (BEST if equal else ''):<3}"


def _section(shown: Table, comparison: Comparison, heading: str, mismatches: Sequence[str]) -> None:
    shown.add_section()
    shown.add_row(f"[bold]{heading}[/bold]")
    for duty in comparison.duty_cycles:
        rows = [comparison.worst(name, [duty], mismatches) for name in comparison.controllers]
        best = min((row.outcome.max_abs_um for row in rows if row.outcome.stopped is None), default=0.0)
        shown.add_row(f"  {duty}", *(cell(row, best) for row in rows))


def _minutes(shown: Table, comparison: Comparison) -> None:
    mismatch = NOMINAL if NOMINAL in comparison.mismatches else comparison.mismatches[0]
    cells = []
    for name in comparison.controllers:
        won = sum(comparison.row(name, duty, mismatch).minutes_won for duty in comparison.duty_cycles)
        cells.append(f"{won:+.0f}   " if name != NO_CONTROLLER else f"{won:+.0f}")
    shown.add_section()
    shown.add_row(
        f"[bold]productive minutes won compared with warming up first[/bold] ({mismatch}, all rows)", *cells
    )

"""What `warmlink simulate` says of a run: last, least and largest values, coupling error, lost heat."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.orchestration.commands.console import answer, answer_json
from warmlink.orchestration.master.error_budget import CouplingError
from warmlink.orchestration.master.recording.result import Result

WIDTH = 160


def give_answer(
    result: Result, bounds: Sequence[CouplingError], head: str, folder: Path, *, as_json: bool
) -> None:
    """Print a run's summary, for people or for machines."""
    summary = _summary(result, bounds, folder)
    if as_json:
        answer_json(summary)
    else:
        _print(summary, head, bool(bounds))


def _summary(result: Result, bounds: Sequence[CouplingError], folder: Path) -> dict[str, Any]:
    errors = {bound.variable: _finite(bound.largest) for bound in bounds}
    return {
        "stop_time_s": float(result.times[-1]) if len(result.times) else None,
        "stopped": result.reason,
        "remarks": list(result.remarks),
        "compiled": result.statistics.compiled,
        "largest_lag_s": result.statistics.largest_lag,
        "results": str(folder),
        "outputs": {
            name: _figures(result, name) | ({"coupling_error": errors[name]} if name in errors else {})
            for name in result.table.names
            if len(result.times)
        },
        "heat_balances": [
            {
                "delivered": audit.balance.delivered,
                "received": audit.balance.received,
                "unit": audit.unit,
                "delivered_total": _finite(audit.delivered),
                "lost": _finite(audit.total),
            }
            for audit in result.audits
        ],
    }


def _figures(result: Result, name: str) -> dict[str, Any]:
    column = result[name]
    # A camera without a picture gives NaN, and means it.
    known = column[np.isfinite(column)]
    return {
        "unit": result.table.units[name],
        "last": _finite(float(column[-1])),
        "min": float(known.min()) if len(known) else None,
        "max": float(known.max()) if len(known) else None,
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _print(summary: dict[str, Any], head: str, bounded: bool) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(title=head, title_justify="left", box=None)
    headings = ["output", "unit", "last", "least", "largest", *(["coupling error"] if bounded else [])]
    for heading in headings:
        text = heading in ("output", "unit")
        table.add_column(heading, justify="left" if text else "right", no_wrap=text)
    for name, figures in summary["outputs"].items():
        cells = [_cell(figures[key]) for key in ("last", "min", "max")]
        if "coupling_error" in figures:
            bound = figures["coupling_error"]
            cells.append("unknown" if bound is None else f"±{bound:.2g}")
        table.add_row(name, figures["unit"] or "1", *cells)
    console = Console()
    # In a file there is no edge to keep within.
    (console if console.is_terminal else Console(width=WIDTH)).print(table)
    for balance in summary["heat_balances"]:
        answer(
            f"heat  {balance['delivered']} {_cell(balance['delivered_total'])} {balance['unit'] or ''}, "
            f"of which {_cell(balance['lost'])} have not reached {balance['received']}"
        )
    if summary["largest_lag_s"]:
        answer(f"largest delay behind the clock  {summary['largest_lag_s']:.3g} s")
    answer(f"results  {summary['results']}")


def _cell(value: float | None) -> str:
    return "-" if value is None else f"{value:.6g}"

"""What `warmlink simulate` answers: outputs with the bounds of their errors, balances of heat, remarks."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warmlink.orchestration.command_line import arguments
from warmlink.orchestration.console import answer, answer_json, print_table, remark

if TYPE_CHECKING:
    from warmlink.orchestration.master.error_budget import Attempt
    from warmlink.orchestration.master.recording.result import Result

WIDTH = 160
MOST_SHOWN = 12
"""Outputs in the table where none is watched."""


def answer_run(
    found: Attempt,
    folder: Path,
    head: str,
    watch: Sequence[str] | None,
    statistics: bool,
    quiet: bool,
    json: bool,
) -> None:
    """Say how the run went, as JSON or as a table under a heading."""
    result = found.result
    summary = _summary(result, found.stopped, found.bounds, folder)
    if json:
        answer_json(summary)
    else:
        if not quiet:
            _print_table(summary, head, watch)
        _print_rest(summary)
        if statistics:
            arguments.print_statistics(result.statistics)
    for told in result.remarks:
        remark(told)


def _summary(
    result: Result, stopped: str | None, bounds: Mapping[str, float], folder: Path
) -> dict[str, Any]:
    import numpy as np

    outputs: dict[str, dict[str, Any]] = {}
    for name in result.table.names if len(result.times) else ():
        column, unit = result[name], result.table.units[name]
        # A camera that has taken no picture yet reads NaN: this is no fault.
        finite = column[np.isfinite(column)]
        ends = (finite.min().item(), finite.max().item()) if len(finite) else (None, None)
        outputs[name] = {"unit": unit, "last": _finite(column[-1].item()), "min": ends[0], "max": ends[1]}
        if name in bounds:
            outputs[name]["coupling_error"] = _finite(bounds[name])
    balances = []
    for audit in result.audits:
        found = {"delivered_total": _finite(audit.delivered), "lost": _finite(audit.total)}
        balances.append({**asdict(audit.balance), "unit": audit.unit, **found})
    return {
        "stop_time_s": float(result.times[-1]) if len(result.times) else None,
        "stopped": stopped,
        "remarks": list(result.remarks),
        "compiled": result.statistics.compiled,
        **({"statistics": result.statistics.to_dict()} if result.statistics.slaves else {}),
        "largest_lag_s": result.statistics.largest_lag,
        "results": str(folder),
        "outputs": outputs,
        "heat_balances": balances,
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _print_table(summary: dict[str, Any], head: str, watched: Sequence[str] | None) -> None:
    """Print the outputs that are watched, or the first ones where none is."""
    outputs: dict[str, dict[str, Any]] = summary["outputs"]
    shown = [name for name in outputs if name in watched] if watched else list(outputs)[:MOST_SHOWN]
    bounded = any("coupling_error" in outputs[name] for name in shown)
    headings = ["output", "unit", "last", "least", "largest", *(["coupling error"] if bounded else [])]
    rows = []
    for name in shown:
        figures = outputs[name]
        cells = [_cell(figures[key]) for key in ("last", "min", "max")]
        if "coupling_error" in figures:
            bound = figures["coupling_error"]
            cells.append("unknown" if bound is None else f"±{bound:.2g}")
        rows.append((name, figures["unit"] or "1", *cells))
    print_table(head, headings, rows, texts=2, width=WIDTH)
    if len(outputs) > len(shown):
        more = len(outputs) - len(shown)
        answer(f"{more} more outputs are in the results; --watch chooses what is shown")


def _print_rest(summary: dict[str, Any]) -> None:
    for balance in summary["heat_balances"]:
        unit = f" {balance['unit']}" if balance["unit"] else ""
        answer(
            f"heat  {balance['delivered']} {_cell(balance['delivered_total'])}{unit}, "
            f"of which {_cell(balance['lost'])}{unit} did not reach {balance['received']}"
        )
    if summary["largest_lag_s"]:
        answer(f"largest delay behind the clock  {summary['largest_lag_s']:.3g} s")
    answer(f"results  {summary['results']}")


def _cell(value: float | None) -> str:
    return "-" if value is None else str(value) if isinstance(value, int) else f"{value:.6g}"

"""The report of a comparison: how far off with each controller, and what each of them says."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from warmlink.orchestration.closed_loop.metrics import CONDUCT, shown_percent
from warmlink.orchestration.report.figures import heat_map
from warmlink.orchestration.report.page import PageTable, Section, write_page
from warmlink.orchestration.scenarios import mismatch as mismatches
from warmlink.orchestration.scenarios.mismatch import NOMINAL
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER
from warmlink.orchestration.studies.compare import Comparison, Row

_HEADINGS = (
    "controller",
    "duty cycle",
    "mismatch",
    "largest [µm]",
    "95 % below [µm]",
    "within tolerance from [min]",
    "removed [%]",
    "equal within [µm]",
    "",
)


def write_comparison(comparison: Comparison, path: Path) -> None:
    """Write `report.html`."""
    sections = []
    controllers, duties = comparison.controllers, comparison.duty_cycles
    if NOMINAL in comparison.mismatches:
        rows = [[comparison.row(name, duty) for name in controllers] for duty in duties]
        sections.append(_map("Every parameter as the controllers assume it", rows, duties))
    others = [name for name in comparison.mismatches if name != NOMINAL]
    if others:
        rows = [[comparison.worst(name, [duty], others) for name in controllers] for duty in duties]
        text = f"The worst of {', '.join(others)}: point at a figure to see which one."
        sections.append(_map("Worst mismatch of each cell", rows, duties, text))
        every = comparison.mismatches
        rows = [[comparison.worst(name, duties, [mismatch]) for name in controllers] for mismatch in every]
        text = "The worst of all duty cycles: point at a figure to see which one."
        sections.append(_map("Mismatch by mismatch", rows, every, text))
    differing = [(name, _about(name)) for name in comparison.mismatches]
    sections += [
        Section(
            "Productive minutes won against warming up first",
            "Minutes within tolerance, less those that warming up first gives: no compensation, and the zero "
            "set once, at the moment that suits that duty cycle best.",
            table=_won(comparison),
        ),
        Section(
            "What the controllers say, and how they move",
            "The worst of all runs: the least time in which a controller says that it is ready, how much of "
            "this is outside the tolerance, how much of the time within tolerance it is not ready, how far "
            "its correction moves to and fro in an hour, and how far it leaps in one step.",
            table=_conduct(comparison),
        ),
        Section("Mismatches", table=PageTable(("mismatch", "what differs"), differing)),
        Section(
            "Every run",
            "Equal within: bound of the coupling error by a run with half the step, plus the link's own "
            "estimate of its grid's error. Scores that differ by less are equal.",
            table=PageTable(_HEADINGS, [_cells(row) for row in comparison.rows.values()]),
        ),
    ]
    write_page(path, "Controllers compared", _lead(comparison), sections)


def _lead(comparison: Comparison) -> str:
    size = len(comparison.duty_cycles) * len(comparison.mismatches)
    kept = {
        name: size - sum(row.defeated for row in comparison.rows.values() if row.controller == name)
        for name in comparison.controllers
        if name != NO_CONTROLLER
    }
    parts = [f"{name} stays within tolerance in {count} of {size} runs" for name, count in kept.items()]
    return "; ".join(parts) + "." if parts else "No controller was asked for beside none."


def worst_errors(comparison: Comparison) -> Any:
    """Heat map of the largest errors over all mismatches, of each controller in each duty cycle."""
    duties, controllers, every = comparison.duty_cycles, comparison.controllers, comparison.mismatches
    rows = [[comparison.worst(name, [duty], every) for name in controllers] for duty in duties]
    return _largest(rows, duties)


def _map(heading: str, rows: list[list[Row]], names: Sequence[str], text: str = "") -> Section:
    """Section with the heat map of the largest errors."""
    what = "Largest error in µm, and the share of the uncompensated one that was removed."
    return Section(heading, f"{what} {text}".strip(), figure=_largest(rows, names))


def _largest(rows: list[list[Row]], names: Sequence[str]) -> Any:
    """Heat map of the largest errors, a column for each controller and a named line for each of the rows."""
    figure = heat_map(
        [row.controller for row in rows[0]],
        names,
        [[row.outcome.max_abs_um for row in line] for line in rows],
        [[_cell(row) for row in line] for line in rows],
        rows[0][0].tolerance_um,
        "µm",
    )
    figure.update_traces(
        customdata=[[f"{row.duty_cycle}, {row.mismatch}" for row in line] for line in rows],
        hovertemplate="%{x}: %{text}<br>%{customdata}<extra></extra>",
    )
    return figure


def _cell(row: Row) -> str:
    if row.outcome.stopped is not None:
        return "stopped"
    error = f"{row.outcome.max_abs_um:.1f}"
    if row.controller == NO_CONTROLLER or row.removed_percent is None:
        return error
    return f"{error}<br>{shown_percent(row.removed_percent)}"


def _won(comparison: Comparison) -> PageTable:
    mismatch = NOMINAL if NOMINAL in comparison.mismatches else comparison.mismatches[0]
    lines = []
    for duty in comparison.duty_cycles:
        rows = [comparison.row(name, duty, mismatch) for name in comparison.controllers]
        best = f"{rows[0].outcome.warm_up_first_min:.0f}"
        lines.append((duty, best, *(f"{row.minutes_won:+.0f}" for row in rows)))
    return PageTable((f"duty cycle ({mismatch})", "warming up first", *comparison.controllers), lines)


def _conduct(comparison: Comparison) -> PageTable:
    """A line for each controller that finished a run."""
    headings = ("ready [%]", "of it wrong [%]", "fine, not ready [%]", "travel [µm/h]", "leap [µm]")
    lines = []
    for name in comparison.controllers:
        rows = [row for row in comparison.rows.values() if row.controller == name]
        ran = [row.outcome for row in rows if row.outcome.ready_percent is not None]
        if ran:
            every = [[getattr(each, of) for each in ran] for of in CONDUCT]
            shown = min(every[0]), *map(max, every[1:])
            lines.append((name, *(f"{value:.3g}" if value < 1e3 else f"{value:.0f}" for value in shown)))
    return PageTable(("controller", *headings), lines)


def _about(name: str) -> str:
    known = name in mismatches.names() or name.startswith("draw_")
    return mismatches.load(name).about if known else "from a file"


def _cells(row: Row) -> tuple[str, ...]:
    found, run = row.outcome, (row.controller, row.duty_cycle, row.mismatch)
    if found.stopped is not None:
        return (*run, *("",) * 5, f"stopped: {found.stopped}")
    settled, removed, equal = found.time_to_tolerance_s, row.removed_percent, row.equal_within_um
    remark = "worse than none" if row.worse_than_none else "beyond tolerance" if row.beyond_tolerance else ""
    return (
        *(*run, f"{found.max_abs_um:.2f}", f"{found.p95_abs_um:.2f}"),
        "never" if settled is None else f"{settled / 60:.1f}",
        "" if removed is None else f"{removed:.1f}",
        "" if equal is None else f"{equal:.2g}",
        remark,
    )

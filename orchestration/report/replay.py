"""The page of controllers that were judged on measured logs."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

from warmlink.orchestration.replay.compare import FIGURES, Replayed, ReplayFigures
from warmlink.orchestration.report.figures import heat_map
from warmlink.orchestration.report.page import PageTable, Section, write_page

_SHOWN = {
    "removed_percent": "removed [%]",
    "rms_um": "rms [µm]",
    "worst_um": "worst after 2 min [µm]",
    "outside_percent": "outside [%]",
    "ready_percent": "ready [%]",
    "ready_wrong_percent": "of it wrong [%]",
    "fine_not_ready_percent": "fine, not ready [%]",
    "travel_um_h": "travel [µm/h]",
    "leap_um": "leap [µm]",
}


def write_replayed(found: Replayed, path: Path) -> None:
    """Write `report.html`."""
    rms = [[found.rows[law, log].rms_um for law in found.controllers] for log in found.logs]
    shown = [[f"{value:.2g}" for value in line] for line in rms]
    headings = ("controller", *(_SHOWN[name] for name in FIGURES))
    sections = [
        Section(
            "All logs together",
            "Median over the logs of what was removed and of the rms error; the largest error of all; the "
            "mean of the others. A controller saw what was logged; one with a camera saw the growth whenever "
            "it was measured, minus its own correction.",
            PageTable(headings, found.table()),
        ),
        Section(
            "Rms error of each log",
            "In µm.",
            figure=heat_map(found.controllers, found.logs, rms, shown, found.tolerance_um, "µm"),
        ),
        Section("Every log", table=PageTable(("controller", "log", *_SHOWN.values()), _rows(found))),
    ]
    best = min(found.controllers, key=lambda law: found.over_all(law)["rms_um"])
    lead = f"{best} has the smallest error: {found.over_all(best)['rms_um']:.2g} µm rms in the median log."
    write_page(path, "Controllers judged on measured logs", lead, sections)


def _rows(found: Replayed) -> list[tuple[str, ...]]:
    names = [each.name for each in fields(ReplayFigures) if each.name in _SHOWN]
    rows = []
    for (law, log), row in found.rows.items():
        values = (getattr(row, name) for name in names)
        rows.append((law, log, *("" if value is None else f"{value:.3g}" for value in values)))
    return rows

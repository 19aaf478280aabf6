"""The page of a law that was learnt from logs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from warmlink.orchestration.replay.learn import LearntLaw
from warmlink.orchestration.report.figures import COLOURS, chart
from warmlink.orchestration.report.page import PageTable, Section, write_page

MOST_SETS = 16
"""Sets of thermometers that the table shows."""


def write_learnt(found: LearntLaw, path: Path) -> None:
    """Write the page."""
    lines = found.summary().splitlines()
    sections = [
        Section(
            "The law",
            f"Temperatures in degC, correction in µm, ready to be typed into a control: `{found.formula}`. "
            "The parameter set of the FMU smooths it, infers a thermometer that is missing from the others, "
            "leaves out readings that do not fit, and says how far it may be off.",
            PageTable(("thermometer", "µm/K", "without it [µm rms more]"), _coefficients(found)),
            figure=_held_out(found),
        ),
        Section(
            "Which thermometers are worth their cable",
            "Rms error of what was held out, by the thermometers that a law goes by; the best sets, and "
            "each thermometer alone.",
            PageTable(("thermometers", "held-out rms [µm]"), _sets(found)),
        ),
        Section(
            "How much log is enough",
            "Rms error of the last third of the logs, by how much from their beginning was learnt from.",
            PageTable(
                ("minutes of log", "rms [µm]"),
                [(f"{minutes:g}", f"{rms:.2g}") for minutes, rms in found.curve_um.items()],
            ),
        ),
        Section(
            "What the rest goes with",
            "Correlation of what the law leaves with other signals of the log; near 0 is none.",
            PageTable(
                ("signal", "correlation"), [(name, f"{r:+.2f}") for name, r in found.correlates.items()]
            ),
        ),
    ]
    names = ", ".join(each.name for each in found.logs)
    write_page(path, f"{found.law} learnt from {names}", f"{'; '.join(lines)}.", sections)


def _coefficients(found: LearntLaw) -> list[tuple[str, str, str]]:
    costs = found.worth_um
    return [
        (name, f"{value:.3f}", f"{max(costs[name], 0.0):.2g}" if name in costs else "")
        for name, value in found.coefficients_um.items()
    ]


def _sets(found: LearntLaw) -> list[tuple[str, str]]:
    """The best sets, and every thermometer alone."""
    every = list(found.thermometers_um.items())
    alone = [each for each in every[MOST_SETS:] if "," not in each[0]]
    return [(names, f"{rms:.2g}") for names, rms in (*every[:MOST_SETS], *alone)]


def _held_out(found: LearntLaw) -> Any:
    """Growth that was measured and errors of predictions from the other blocks."""
    learnt = found.learnt
    rows = learnt.examples
    error = rows.growth - learnt.line.at(rows.temperature[:, learnt.used])
    hours = np.arange(rows.growth.size) if np.ptp(rows.log) else rows.time / 3600
    left = {"type": "scatter", "mode": "markers", "marker": {"color": COLOURS[1], "size": 4}}
    traces = [{**left, "x": hours, "y": 1e6 * error, "name": "measured minus law"}]
    title = "number of the reading" if np.ptp(rows.log) else "time [h]"
    return chart(*traces, x={"title": title}, y={"title": "what the law leaves [µm]"}, height=320)

"""The report of one scenario in closed loop."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from warmlink.fmus.names import listed
from warmlink.orchestration.arm.geometry import NAME as ARM
from warmlink.orchestration.closed_loop.metrics import ErrorMetrics
from warmlink.orchestration.closed_loop.outcome import ClosedLoop
from warmlink.orchestration.report.figures import Band, Line, time_plot
from warmlink.orchestration.report.page import Section, Table, versions, write_page
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER
from warmlink.orchestration.scenarios.setup import CELL
from warmlink.orchestration.system.units import ZERO_CELSIUS

QUANTITIES = {
    "m": ("length [µm]", 1e6, 0.0),
    "K": ("temperature [°C]", 1.0, ZERO_CELSIUS),
    "W": ("heat flow [W]", 1.0, 0.0),
}
"""Label, factor and zero by unit."""

CELL_PLOTS = {
    ("Elongation and correction", "m"): {
        "elongation": "link.elongation",
        "correction": "compensator.correction",
    },
    ("Temperatures", "K"): {
        "winding": "motor.winding_temperature",
        "shaft": "motor.shaft_temperature",
        "link, base": "link.base_temperature",
        "link, middle": "link.sensor_temperature[2]",
        "link, tip": "link.tip_temperature",
        "surroundings": "duty.ambient_temperature",
    },
    ("Heat flows", "W"): {
        "motor to link": "motor.heat_flow",
        "link's surface to surroundings": "link.surface_heat_loss",
    },
}
"""What is plotted of the warm-up cell: variables by the name of their line."""


def write_report(outcome: ClosedLoop, path: Path, live_page: str = "") -> None:
    """Write `report.html`; `live_page` is a file beside it in which the scenario runs, where there is one."""
    scenario = outcome.scenario
    write_page(
        path,
        f"{scenario.title} · {outcome.controller}",
        _lead(outcome),
        [
            Section("Figures", text=scenario.about.strip(), table=_figures(outcome)),
            Section(
                "Error of the tool point",
                _ERROR_TEXT.format(score=scenario.setup.roles.score.text),
                figure=_error_plot(outcome),
            ),
            *_of_the_system(outcome),
            *([Section("Try it", _LIVE_TEXT, page=live_page)] if live_page else []),
            Section("How far to trust this", _trust(outcome), table=_budget(outcome)),
            Section("Settings", table=_settings(outcome)),
            *_calls(outcome),
            Section("Versions", table=versions()),
        ],
    )


_ERROR_TEXT = "{score}, at the communication points."

_LIVE_TEXT = "Drag the duty cycle, move parameters, give thermometers faults, and see the error at once."

MOST_LINES = 10
"""Most lines in a plot of a user's own system."""


def _calls(outcome: ClosedLoop) -> list[Section]:
    """What each FMU was asked for, where that was counted."""
    statistics = outcome.result.statistics
    if not statistics.slaves:
        return []
    return [Section("Calls of each FMU", f"{statistics.summary()}.", Table(*statistics.table()))]


def _of_the_system(outcome: ClosedLoop) -> list[Section]:
    """Sections that depend on the system: the arm's, the cell's, or any other's outputs by their units."""
    system = outcome.scenario.setup.name
    if system == ARM:
        from warmlink.orchestration.report.arm import sections

        return sections(outcome)
    plots = (
        CELL_PLOTS if system == CELL.name else {(h, unit): _of_unit(outcome, unit) for h, unit in OWN_PLOTS}
    )
    return [Section(h, figure=_plot(outcome, unit, lines)) for (h, unit), lines in plots.items()]


OWN_PLOTS = (("Lengths", "m"), ("Temperatures", "K"), ("Heat flows", "W"))


def _of_unit(outcome: ClosedLoop, unit: str) -> dict[str, str]:
    """Variables of a system of one's own, under their own names."""
    units = outcome.result.table.units
    names = [name for name in outcome.result.table.names if units[name] == unit and "[" not in name]
    return {name: name for name in names[:MOST_LINES]}


def _plot(outcome: ClosedLoop, unit: str, variables: Mapping[str, str]) -> object:
    label, factor, zero = QUANTITIES[unit]
    lines = [Line(name, factor * (outcome.result[of] - zero)) for name, of in variables.items()]
    return time_plot(outcome.time, lines, label)


def _lead(outcome: ClosedLoop) -> str:
    before, after = outcome.uncompensated, outcome.metrics
    settled = after.time_to_tolerance_s
    tolerance = f"±{1e6 * outcome.scenario.tolerance:g} µm"
    if settled is None:
        when = f"it does not stay within {tolerance}"
    elif settled == 0:
        when = f"it stays within {tolerance} from the start"
    else:
        when = f"it stays within {tolerance} from {settled / 60:.1f} min"
    told = "".join(f" {text[0].upper()}{text[1:]}." for text in (*_cut_short(outcome), *outcome.remarks))
    return (
        f"Without compensation the tool point is off by up to {before.max_abs_um:.1f} µm; with "
        f"{outcome.controller} by up to {after.max_abs_um:.1f} µm, and {when}.{told}"
    )


def _cut_short(outcome: ClosedLoop) -> tuple[str, ...]:
    return () if outcome.cut_short is None else (f"stopped early: {outcome.cut_short}",)


def _figures(outcome: ClosedLoop) -> Table:
    before, after = outcome.uncompensated, outcome.metrics
    rows = [
        ("largest error", f"{before.max_abs_um:.2f} µm", f"{after.max_abs_um:.2f} µm"),
        ("95 % of the time below", f"{before.p95_abs_um:.2f} µm", f"{after.p95_abs_um:.2f} µm"),
        ("root mean square", f"{before.rms_um:.2f} µm", f"{after.rms_um:.2f} µm"),
        (f"within ±{1e6 * outcome.scenario.tolerance:g} µm from", _when(before), _when(after)),
    ]
    return Table(("", NO_CONTROLLER, outcome.controller), rows)


def _when(metrics: ErrorMetrics) -> str:
    if metrics.time_to_tolerance_s is None:
        return "never"
    return "start" if metrics.time_to_tolerance_s == 0 else f"{metrics.time_to_tolerance_s / 60:.1f} min"


def _error_plot(outcome: ClosedLoop) -> object:
    tolerance = 1e6 * outcome.scenario.tolerance
    lines = [
        Line(outcome.controller, 1e6 * outcome.error),
        Line(NO_CONTROLLER, 1e6 * outcome.uncompensated_error),
    ]
    band = Band(-tolerance, tolerance, f"±{tolerance:g} µm")
    return time_plot(outcome.time, lines, "error [µm]", band)


def _trust(outcome: ClosedLoop) -> str:
    return (
        "The coupling error is bounded by a second run with half the communication step. The discretisation "
        "error is the links' own estimate for their grids. A heat balance is the heat that left one part "
        "minus the heat that reached the next one; only the coupling makes it differ from 0."
    )


def _budget(outcome: ClosedLoop) -> Table:
    rows = [
        (
            f"coupling error of {listed(outcome.scenario.setup.roles.plant)}, at most",
            _bound(outcome.coupling_error_um),
        ),
        ("discretisation error of any elongation, at most", _bound(outcome.discretisation_error_um)),
    ]
    for audit in outcome.result.audits:
        share = abs(audit.total) / max(abs(audit.delivered), 1e-12)
        rows.append(
            (
                f"heat balance over the run: {audit.balance.delivered} minus {audit.balance.received}",
                f"{audit.total:.3g} J ({share:.2g} of the heat delivered)",
            )
        )
        rows.append(("largest imbalance of this kind in one step", f"{audit.largest_step:.3g} J"))
    return Table(("", "value"), rows)


def _bound(micrometres: float | None) -> str:
    return "unknown, a run stopped early" if micrometres is None else f"±{micrometres:.2g} µm"


def _settings(outcome: ClosedLoop) -> Table:
    scenario = outcome.scenario
    rows = [
        ("scenario", scenario.name),
        ("stop time", f"{scenario.stop_time:g} s"),
        ("communication step size", f"{scenario.step_size:g} s"),
        ("master algorithm", scenario.master),
        ("FMUs", outcome.fmus),
        ("controller", outcome.controller),
        ("mismatches", ", ".join(scenario.mismatches) or "none"),
        ("tolerance", f"±{1e6 * scenario.tolerance:g} µm"),
        *((name, str(value)) for name, value in scenario.parameters.items()),
        ("computed in", f"{outcome.wall_seconds:.2f} s"),
        ("communication points", f"{np.size(outcome.time)}"),
    ]
    return Table(("setting", "value"), rows)

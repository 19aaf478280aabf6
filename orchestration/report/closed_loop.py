"""The report of one scenario in closed loop."""

from __future__ import annotations

import math
from collections.abc import Mapping
from importlib.metadata import EntryPoint
from itertools import groupby
from pathlib import Path

import numpy as np

from warmlink.fmus.names import listed
from warmlink.orchestration.closed_loop.metrics import ErrorMetrics
from warmlink.orchestration.closed_loop.outcome import ClosedLoop
from warmlink.orchestration.machine.machine import Machine, Plots
from warmlink.orchestration.report.figures import time_plot
from warmlink.orchestration.report.page import PageTable, Section, unwrapped, write_page
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER, Scenario
from warmlink.orchestration.system.units import ZERO_CELSIUS

QUANTITIES = {
    "m": ("length [µm]", 1e6, 0.0),
    "K": ("temperature [°C]", 1.0, ZERO_CELSIUS),
    "W": ("heat flow [W]", 1.0, 0.0),
}
"""Label, factor and zero by unit."""

OWN_PLOTS = (("Lengths", "m"), ("Temperatures", "K"), ("Heat flows", "W"))
"""What is plotted of a machine that does not say it: outputs by their unit, under their own names."""

MOST_LINES = 10
"""Most lines in such a plot."""


def write_report(outcome: ClosedLoop, path: Path, live_page: str = "") -> None:
    """Write `report.html`; `live_page` is a file beside it in which the scenario runs, where there is one."""
    scenario, statistics = outcome.scenario, outcome.result.statistics
    errors = {outcome.controller: 1e6 * outcome.error, NO_CONTROLLER: 1e6 * outcome.uncompensated_error}
    sections = [
        Section("Figures", text=unwrapped(scenario.about), table=_figures(outcome)),
        Section(
            "Error of the tool point",
            f"{scenario.machine.roles.score.text}, at the communication points.",
            figure=time_plot(outcome.time, errors, "error [µm]", 1e6 * scenario.tolerance),
        ),
        *_of_the_system(outcome),
        Section(
            "How far to trust this",
            "The coupling error is bounded by a second run with half the communication step. The "
            "discretisation error is the links' own estimate for their grids. A heat balance is the heat "
            "that left one part minus the heat that reached the next one; only the coupling makes it differ "
            "from 0.",
            table=_budget(outcome),
        ),
        Section("Settings", table=_settings(outcome)),
    ]
    if live_page:
        text = "Drag the duty cycle, move parameters, give thermometers faults, and see the error at once."
        sections.insert(-2, Section("Try it", text, page=live_page))
    if statistics.slaves:
        table = PageTable(*statistics.table())
        sections.append(Section("Calls of each FMU", f"{statistics.summary()}.", table))
    write_page(path, f"{scenario.title} · {outcome.controller}", _lead(outcome), sections)


def _of_the_system(outcome: ClosedLoop) -> list[Section]:
    """Sections that depend on the machine: its own, or what it plots."""
    machine, table = outcome.scenario.machine, outcome.result.table
    if machine.sections:
        made: list[Section] = EntryPoint("", machine.sections, "").load()(outcome)
        return made
    plots = plots_of(machine, {name: table.units[name] for name in table.names if "[" not in name})
    sections = []
    for (heading, unit), variables in plots.items():
        label, factor, zero = QUANTITIES[unit]
        lines = {name: factor * (outcome.result[of] - zero) for name, of in variables.items()}
        sections.append(Section(heading, figure=time_plot(outcome.time, lines, label)))
    return sections


def plots_of(machine: Machine, units: Mapping[str, str | None]) -> Plots:
    """Variables that are plotted for a machine; `units` has every variable that may be."""
    return machine.plots or {
        (heading, unit): {n: n for n in [n for n in units if units[n] == unit][:MOST_LINES]}
        for heading, unit in OWN_PLOTS
    }


def _lead(outcome: ClosedLoop) -> str:
    before, after, since = outcome.uncompensated, outcome.metrics, _since(outcome.metrics)
    tolerance = f"±{1e6 * outcome.scenario.tolerance:g} µm"
    stays = "does not stay" if since == "never" else "stays"
    when = {"never": "", "start": " from the start"}.get(since, f" from {since}")
    cut = [] if outcome.cut_short is None else [f"stopped early: {outcome.cut_short}"]
    told = "".join(f" {text[0].upper()}{text[1:]}." for text in (*cut, *outcome.remarks))
    return (
        f"Without compensation the tool point is off by up to {before.max_abs_um:.1f} µm; with "
        f"{outcome.controller} by up to {after.max_abs_um:.1f} µm, and it {stays} within {tolerance}{when}."
        f"{told}"
    )


def _figures(outcome: ClosedLoop) -> PageTable:
    kinds = outcome.uncompensated, outcome.metrics
    rows = [
        ("largest error", *(f"{each.max_abs_um:.2f} µm" for each in kinds)),
        ("95 % of the time below", *(f"{each.p95_abs_um:.2f} µm" for each in kinds)),
        ("root mean square", *(f"{each.rms_um:.2f} µm" for each in kinds)),
        (f"within ±{1e6 * outcome.scenario.tolerance:g} µm from", *map(_since, kinds)),
    ]
    told = outcome.conduct
    rows += [
        (word, "", value)
        for word, value in (
            ("ready, of the time", _percent(told.ready_percent, 1)),
            ("outside the tolerance, of the time ready", _percent(told.ready_wrong_percent, 2)),
            ("not ready, of the time within tolerance", _percent(told.fine_not_ready_percent, 1)),
            ("the correction travels", f"{told.travel_um_h:.1f} µm/h"),
            ("its largest leap in one step", f"{told.leap_um:.2g} µm"),
        )
    ]
    return PageTable(("", NO_CONTROLLER, outcome.controller), rows)


def _percent(share: float, decimals: int) -> str:
    return "not said" if math.isnan(share) else f"{share:.{decimals}f} %"


def _since(metrics: ErrorMetrics) -> str:
    if metrics.time_to_tolerance_s is None:
        return "never"
    return "start" if metrics.time_to_tolerance_s == 0 else f"{metrics.time_to_tolerance_s / 60:.1f} min"


def _budget(outcome: ClosedLoop) -> PageTable:
    errors = {
        f"coupling error of {listed(outcome.scenario.machine.roles.plant)}": outcome.coupling_error_um,
        "discretisation error of any elongation": outcome.discretisation_error_um,
    }
    unknown = "unknown, a run stopped early"
    rows = [(f"{of}, at most", f"±{um:.2g} µm" if um is not None else unknown) for of, um in errors.items()]
    for audit in outcome.result.audits:
        share = abs(audit.total) / max(abs(audit.delivered), 1e-12)
        ends = f"{audit.balance.delivered} minus {audit.balance.received}"
        held = f"{audit.total:.3g} J ({share:.2g} of the heat delivered)"
        rows.append((f"heat balance over the run: {ends}", held))
        rows.append(("largest imbalance of this kind in one step", f"{audit.largest_step:.3g} J"))
    return PageTable(("", "value"), rows)


def _settings(outcome: ClosedLoop) -> PageTable:
    scenario = outcome.scenario
    rows = {
        "scenario": scenario.name,
        "stop time": f"{scenario.stop_time:g} s",
        "communication step size": f"{scenario.step_size:g} s",
        "master algorithm": scenario.master,
        "FMUs": outcome.fmus,
        "controller": outcome.controller,
        "mismatches": ", ".join(scenario.mismatches) or "none",
        "tolerance": f"±{1e6 * scenario.tolerance:g} µm",
        **_changed(scenario),
        "computed in": f"{outcome.wall_seconds:.2f} s",
        "communication points": f"{np.size(outcome.time)}",
    }
    return PageTable(("setting", "value"), [*rows.items()])


def _changed(scenario: Scenario) -> dict[str, str]:
    """The parameters that differ from nominal, each with its unit, and arrays in a row each."""
    units = {
        f"{instance}.{scalar.name}": scalar.variable.unit
        for instance, component in scenario.declared.items()
        for scalar in component.scalars()
    }
    rows: dict[str, str] = {}
    for _, group in groupby(enumerate(scenario.parameters.items()), _in_one_row):
        (first, value), *more = (item for _, item in group)
        name = f"{first[:-1]}..{more[-1][0].partition('[')[2]}" if more else first
        unit = units.get(first, "")
        shown = f"{value:.6g} {'' if unit == '1' else unit}" if isinstance(value, float) else str(value)
        alike = all(each == value for _, each in more)
        rows[name] = shown.strip() if alike else f"{len(more) + 1} values"
    return rows


def _in_one_row(placed: tuple[int, tuple[str, object]]) -> tuple[str, int]:
    """What elements of an array that follow each other have in common; others have nothing."""
    place, (name, _) = placed
    array, _, element = name.partition("[")
    return (array, int(element[:-1]) - place) if element else (name, 0)

"""The report of one scenario in closed loop: the cell's, any system's, and what the arm has besides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.fmus.arm_kinematics.equations import COORDINATES
from warmlink.fmus.names import listed
from warmlink.orchestration.arm.blueprint import NAME as ARM
from warmlink.orchestration.arm.blueprint import axes
from warmlink.orchestration.arm.errors import ArmErrors, Workspace, by_name, columns, workspace
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.closed_loop.metrics import ErrorMetrics
from warmlink.orchestration.closed_loop.outcome import ClosedLoop
from warmlink.orchestration.report.figures import styled, time_plot
from warmlink.orchestration.report.page import Section, Table, unwrapped, write_page
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER, Scenario
from warmlink.orchestration.scenarios.setup import CELL
from warmlink.orchestration.system.units import ZERO_CELSIUS

QUANTITIES = {
    "m": ("length [µm]", 1e6, 0.0),
    "K": ("temperature [°C]", 1.0, ZERO_CELSIUS),
    "W": ("heat flow [W]", 1.0, 0.0),
}
"""Label, factor and zero by unit."""

Plots = Mapping[tuple[str, str], Mapping[str, str]]
"""Variables by the name of their line, by heading and unit."""

CELL_PLOTS: Plots = {
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

OWN_PLOTS = (("Lengths", "m"), ("Temperatures", "K"), ("Heat flows", "W"))
"""What is plotted of a user's own system: outputs by their unit, under their own names."""

MOST_LINES = 10
"""Most lines in a plot of a user's own system."""


def write_report(outcome: ClosedLoop, path: Path, live_page: str = "") -> None:
    """Write `report.html`; `live_page` is a file beside it in which the scenario runs, where there is one."""
    scenario, statistics = outcome.scenario, outcome.result.statistics
    errors = {outcome.controller: 1e6 * outcome.error, NO_CONTROLLER: 1e6 * outcome.uncompensated_error}
    sections = [
        Section("Figures", text=unwrapped(scenario.about), table=_figures(outcome)),
        Section(
            "Error of the tool point",
            f"{scenario.setup.roles.score.text}, at the communication points.",
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
        table = Table(*statistics.table())
        sections.append(Section("Calls of each FMU", f"{statistics.summary()}.", table))
    write_page(path, f"{scenario.title} · {outcome.controller}", _lead(outcome), sections)


def _of_the_system(outcome: ClosedLoop) -> list[Section]:
    """Sections that depend on the system: the arm's, the cell's, or any other's outputs by their units."""
    system, table = outcome.scenario.setup.name, outcome.result.table
    if system == ARM:
        return _of_the_arm(outcome)
    plots = plots_of(system, {name: table.units[name] for name in table.names if "[" not in name})
    sections = []
    for (heading, unit), variables in plots.items():
        label, factor, zero = QUANTITIES[unit]
        lines = {name: factor * (outcome.result[of] - zero) for name, of in variables.items()}
        sections.append(Section(heading, figure=time_plot(outcome.time, lines, label)))
    return sections


def plots_of(system: str, units: Mapping[str, str | None]) -> Plots:
    """What is plotted of a system by its name; `units` are those of all that may be plotted."""
    if system == CELL.name:
        return CELL_PLOTS
    return {
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


def _figures(outcome: ClosedLoop) -> Table:
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
            ("ready, of the time", f"{told.ready_percent:.1f} %"),
            ("outside the tolerance, of the time ready", f"{told.ready_wrong_percent:.2f} %"),
            ("not ready, of the time within tolerance", f"{told.fine_not_ready_percent:.1f} %"),
            ("the correction travels", f"{told.travel_um_h:.1f} µm/h"),
            ("its largest leap in one step", f"{told.leap_um:.2g} µm"),
        )
    ]
    return Table(("", NO_CONTROLLER, outcome.controller), rows)


def _since(metrics: ErrorMetrics) -> str:
    if metrics.time_to_tolerance_s is None:
        return "never"
    return "start" if metrics.time_to_tolerance_s == 0 else f"{metrics.time_to_tolerance_s / 60:.1f} min"


def _budget(outcome: ClosedLoop) -> Table:
    errors = {
        f"coupling error of {listed(outcome.scenario.setup.roles.plant)}": outcome.coupling_error_um,
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
    return Table(("", "value"), rows)


def _settings(outcome: ClosedLoop) -> Table:
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
    return Table(("setting", "value"), [*rows.items()])


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


def _of_the_arm(outcome: ClosedLoop) -> list[Section]:
    errors, grid, result = ArmErrors(outcome.result), workspace(), outcome.result
    names = [axis.name for axis in axes()]
    uncompensated, left = (_maps(outcome, grid, growth) for growth in (errors.growth, errors.left))

    def plot(
        heading: str, label: str, values: Array, named: Sequence[str] = names, text: str = ""
    ) -> Section:
        """Lines over time, one for each column of the values."""
        lines = dict(zip(named, values.T, strict=True))
        return Section(heading, text, figure=time_plot(outcome.time, lines, label))

    def temperatures(heading: str, variable: str) -> Section:
        ambient = result["axis1.duty.ambient_temperature"]
        values = np.column_stack([columns(result, variable), ambient]) - ZERO_CELSIUS
        return plot(heading, "temperature [°C]", values, [*names, "surroundings"])

    return [
        Section(
            "Where it comes from, axis by axis",
            "What each link adds to the error's length at the time when that is largest; each column sums to "
            "the largest error.",
            table=_axes_table(outcome, errors),
        ),
        plot("Elongation of each link", "length [µm]", 1e6 * errors.growth),
        plot("What the compensation of each axis leaves", "length [µm]", 1e6 * errors.left),
        plot("Left over in x, y and z", "error [µm]", 1e6 * errors.tool_error(errors.left), COORDINATES),
        Section(
            "Error over the workspace, uncompensated",
            "Tool pointing down, arm in its vertical plane; turning the waist turns the error with it. "
            "White: out of reach.",
            figure=uncompensated,
        ),
        Section(f"Error over the workspace, with {outcome.controller}", figure=left),
        temperatures("Shafts", "motor.shaft_temperature"),
        temperatures("Links, half-way", "link.sensor_temperature[2]"),
        plot(
            "Heat along the chain",
            "heat flow [W]",
            columns(result, "motor.neighbour_heat_flow")[:, 1:],
            names[1:],
            "Heat from a joint into the tip of the link before it; below zero it takes heat from there.",
        ),
        Section(
            "The arm's figures",
            "Masses, sections and conductances of the arm are estimates, listed in "
            "`orchestration/arm/geometry.toml`. The poses of a program go on through pauses, where they tell "
            "how far off the tool point would be.",
        ),
    ]


def _axes_table(outcome: ClosedLoop, errors: ArmErrors) -> Table:
    kinds = {NO_CONTROLLER: errors.growth, outcome.controller: errors.left}
    shares = [by_name(1e6 * errors.by_axis(each)) for each in kinds.values()]
    largest = by_name(1e6 * errors.growth.max(axis=0))
    left = by_name(1e6 * np.abs(errors.left).max(axis=0))
    rows = [
        [name, f"{largest[name]:.1f} µm", f"{left[name]:.2f} µm", *(f"{of[name]:.2f} µm" for of in shares)]
        for name in largest
    ]
    rows.append(["all", "", "", *(f"{sum(of.values()):.2f} µm" for of in shares)])
    adds = (f"adds: {name}" for name in kinds)
    return Table(("axis", "growth, at most", "left of it, at most", *adds), rows)


def moments(outcome: ClosedLoop) -> list[int]:
    """Communication points of the maps: the worst, and an hour in, half-way and the end unless near it."""
    worst, last = int(np.argmax(np.abs(outcome.uncompensated_error))), len(outcome.time) - 1
    hour = int(np.searchsorted(outcome.time, min(3600.0, outcome.time[-1])))
    return sorted({worst, *(point for point in (hour, last // 2, last) if abs(point - worst) > last / 20)})


def _maps(outcome: ClosedLoop, grid: Workspace, growth: Array) -> Any:
    """Error over the workspace by the growth of the links, at some moments."""
    from plotly.subplots import make_subplots

    points = moments(outcome)
    errors = [1e6 * grid.error(growth[point]) for point in points]
    titles = [f"{outcome.time[point] / 3600:.2f} h" for point in points]
    figure = make_subplots(1, len(points), shared_yaxes=True, subplot_titles=titles, horizontal_spacing=0.03)
    look: dict[str, Any] = {
        "x": 1e3 * grid.out,
        "y": 1e3 * grid.up,
        "zmin": 0.0,
        "zmax": float(np.nanmax(errors)),
        "colorscale": "Viridis",
        "colorbar": {"title": "µm"},
        "hovertemplate": "out %{x:.0f} mm<br>up %{y:.0f} mm<br>%{z:.2f} µm<extra></extra>",
    }
    for place, error in enumerate(errors, start=1):
        figure.add_heatmap(z=error, showscale=place == len(points), row=1, col=place, **look)
    figure.update_xaxes(title="from the waist [mm]")
    figure.update_yaxes(title="height [mm]", row=1, col=1)
    # The titles stand below the buttons.
    return styled(figure, 440, 100 + 180 * len(points)).update_layout(margin_t=90)

"""The report of one scenario of the arm."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.arm_kinematics.equations import COORDINATES
from warmlink.orchestration.arm.error_map import Workspace, workspace
from warmlink.orchestration.arm.geometry import axes
from warmlink.orchestration.arm.outcome import ArmOutcome, Compensation, by_name, columns
from warmlink.orchestration.report.figures import Band, Line, styled, time_plot
from warmlink.orchestration.report.page import Section, Table, versions, write_page
from warmlink.orchestration.scenarios.closed_loop import NO_CONTROLLER
from warmlink.orchestration.scenarios.metrics import ErrorMetrics, reduction_percent

Array = NDArray[np.float64]

ZERO_CELSIUS = 273.15


def write_report(outcome: ArmOutcome, path: Path) -> None:
    """Write `report.html`."""
    scenario = outcome.scenario
    write_page(
        path,
        f"{scenario.title} · {outcome.compensations[0].name}",
        _lead(outcome),
        [
            Section("Figures", text=scenario.program.reason, table=_figures(outcome)),
            Section("Error of the tool point", _ERROR_TEXT, figure=_norm_plot(outcome)),
            Section("Where it comes from, axis by axis", _AXES_TEXT, table=_axes_table(outcome)),
            Section("Elongation of each link", figure=_axis_plot(outcome, outcome.growth)),
            Section(
                "What the compensation of each axis leaves",
                figure=_axis_plot(outcome, outcome.growth - outcome.compensations[0].correction),
            ),
            Section("Left over in x, y and z", figure=_coordinates_plot(outcome)),
            *_maps(outcome),
            Section("Shafts", figure=_temperature_plot(outcome, "motor.shaft_temperature")),
            Section("Links, half-way", figure=_temperature_plot(outcome, "link.sensor_temperature[2]")),
            Section("Heat along the chain", _CHAIN_TEXT, figure=_chain_plot(outcome)),
            Section("How far to trust this", _trust(outcome), table=_budget(outcome)),
            Section("Settings", table=_settings(outcome)),
            Section("Versions", table=versions()),
        ],
    )


_ERROR_TEXT = (
    "Length of the difference between the true tool point and the one that the robot's controller reckons "
    "with, in the pose held at each time. The program's poses go on through pauses, where they tell how far "
    "off the tool point would be."
)
_AXES_TEXT = (
    "What each link adds to the error's length at the time when that is largest; each column sums to the "
    "largest error."
)
_CHAIN_TEXT = "Heat from a joint into the tip of the link before it; below zero it takes heat from there."
_MAP_TEXT = (
    "Tool pointing down, arm in its vertical plane; turning the waist turns the error with it. White: out of "
    "reach."
)


def _lead(outcome: ArmOutcome) -> str:
    before = outcome.metrics()
    used = outcome.compensations[0]
    after = outcome.metrics(used.correction)
    gone = reduction_percent(before, after)
    share = "" if gone is None else f" ({gone:.1f} % less)"
    return (
        f"Without compensation the tool point is off by up to {before.max_abs_um:.0f} µm; with "
        f"{used.name} on each axis and one thermometer a joint by up to {after.max_abs_um:.1f} µm{share}."
    )


def _figures(outcome: ArmOutcome) -> Table:
    kinds: list[Compensation | None] = [None, *outcome.compensations]
    metrics = [outcome.metrics(each.correction if each else None) for each in kinds]
    largest = [np.abs(outcome.tool_error(each.correction if each else None)).max(axis=0) for each in kinds]
    tolerance = f"within {1e6 * outcome.scenario.tolerance:g} µm from"
    rows = [
        ("largest error", *(f"{each.max_abs_um:.2f} µm" for each in metrics)),
        *(
            (f"largest in {name}", *(f"{1e6 * each[k]:.2f} µm" for each in largest))
            for k, name in enumerate(COORDINATES)
        ),
        ("95 % of the time below", *(f"{each.p95_abs_um:.2f} µm" for each in metrics)),
        ("root mean square", *(f"{each.rms_um:.2f} µm" for each in metrics)),
        (tolerance, *(_when(each) for each in metrics)),
        ("removed of the largest", *(_removed(metrics[0], each) for each in metrics)),
    ]
    names = [each.name if each else NO_CONTROLLER for each in kinds]
    return Table(("", *names), rows)


def _when(metrics: ErrorMetrics) -> str:
    if metrics.time_to_tolerance_s is None:
        return "never"
    return "start" if metrics.time_to_tolerance_s == 0 else f"{metrics.time_to_tolerance_s / 60:.1f} min"


def _removed(before: ErrorMetrics, after: ErrorMetrics) -> str:
    gone = reduction_percent(before, after)
    return "" if gone is None or before is after else f"{gone:.1f} %"


def _norm_plot(outcome: ArmOutcome) -> object:
    lines = [
        Line(each.name, 1e6 * _length(outcome.tool_error(each.correction))) for each in outcome.compensations
    ]
    lines.append(Line(NO_CONTROLLER, 1e6 * _length(outcome.tool_error()), dash="dot"))
    tolerance = 1e6 * outcome.scenario.tolerance
    return time_plot(outcome.time, lines, "error [µm]", Band(0.0, tolerance, f"{tolerance:g} µm"))


def _axes_table(outcome: ArmOutcome) -> Table:
    kinds: list[Compensation | None] = [None, *outcome.compensations]
    shares = [by_name(1e6 * outcome.by_axis(each.correction if each else None)) for each in kinds]
    largest = by_name(1e6 * outcome.growth.max(axis=0))
    left = by_name(1e6 * np.abs(outcome.growth - outcome.compensations[0].correction).max(axis=0))
    rows = [
        (
            axis.name,
            f"{largest[axis.name]:.1f} µm",
            f"{left[axis.name]:.2f} µm",
            *(f"{share[axis.name]:.2f} µm" for share in shares),
        )
        for axis in axes()
    ]
    rows.append(("all", "", "", *(f"{sum(share.values()):.2f} µm" for share in shares)))
    names = [each.name if each else NO_CONTROLLER for each in kinds]
    return Table(
        ("axis", "growth, at most", "left of it, at most", *(f"adds: {name}" for name in names)), rows
    )


def _axis_plot(outcome: ArmOutcome, values: Array) -> object:
    lines = [Line(axis.name, 1e6 * values[:, i]) for i, axis in enumerate(axes())]
    return time_plot(outcome.time, lines, "length [µm]")


def _coordinates_plot(outcome: ArmOutcome) -> object:
    error = outcome.tool_error(outcome.compensations[0].correction)
    return time_plot(
        outcome.time, [Line(name, 1e6 * error[:, k]) for k, name in enumerate(COORDINATES)], "error [µm]"
    )


def _temperature_plot(outcome: ArmOutcome, variable: str) -> object:
    values = columns(outcome.result, variable) - ZERO_CELSIUS
    lines = [Line(axis.name, values[:, i]) for i, axis in enumerate(axes())]
    lines.append(
        Line("surroundings", outcome.result["axis1.duty.ambient_temperature"] - ZERO_CELSIUS, dash="dot")
    )
    return time_plot(outcome.time, lines, "temperature [°C]")


def _chain_plot(outcome: ArmOutcome) -> object:
    values = columns(outcome.result, "motor.neighbour_heat_flow")
    lines = [Line(axis.name, values[:, i]) for i, axis in enumerate(axes()) if i > 0]
    return time_plot(outcome.time, lines, "heat flow [W]")


def moments(outcome: ArmOutcome) -> list[int]:
    """Communication points of the maps: the worst, and an hour in, half-way and the end unless near it."""
    worst, last = int(np.argmax(_length(outcome.tool_error()))), len(outcome.time) - 1
    hour = int(np.searchsorted(outcome.time, min(3600.0, outcome.time[-1])))
    return sorted({worst, *(point for point in (hour, last // 2, last) if abs(point - worst) > last / 20)})


def _maps(outcome: ArmOutcome) -> list[Section]:
    grid = workspace()
    used = outcome.compensations[0]
    left = outcome.growth - used.correction
    sections = []
    for heading, values, text in (
        ("Error over the workspace, uncompensated", outcome.growth, _MAP_TEXT),
        (f"Error over the workspace, with {used.name}", left, ""),
    ):
        sections.append(Section(heading, text, figure=_map(grid, outcome.time, values, moments(outcome))))
    return sections


def _map(grid: Workspace, time: Array, growth: Array, points: Sequence[int]) -> Any:
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    errors = [1e6 * grid.error(growth[point]) for point in points]
    top = max(float(np.nanmax(error)) for error in errors)
    titles = [f"{time[point] / 3600:.2f} h" for point in points]
    figure = make_subplots(1, len(points), shared_yaxes=True, subplot_titles=titles, horizontal_spacing=0.03)
    for place, error in enumerate(errors, start=1):
        figure.add_trace(
            go.Heatmap(
                x=1e3 * grid.out,
                y=1e3 * grid.up,
                z=error,
                zmin=0.0,
                zmax=top,
                colorscale="Viridis",
                showscale=place == len(points),
                colorbar={"title": "µm"},
                hovertemplate="out %{x:.0f} mm<br>up %{y:.0f} mm<br>%{z:.2f} µm<extra></extra>",
            ),
            1,
            place,
        )
        figure.update_xaxes(title="from the waist [mm]", row=1, col=place)
    figure.update_yaxes(title="height [mm]", row=1, col=1)
    styled(figure, 440)
    # The titles stand below the buttons.
    return figure.update_layout(margin_t=90)


def _length(error: Array) -> Array:
    return np.asarray(np.linalg.norm(error, axis=1))


def _trust(outcome: ArmOutcome) -> str:
    return (
        "Coupling: bounded by a run with half the communication step. Discretisation: the links' own "
        "estimate for their grids. Heat balance: heat that left the motors less heat that reached the links. "
        "The observers know the nominal parameters of motors and links; the parameters under Settings, where "
        "there are any, are what the arm has besides. Masses, sections and conductances of the arm are "
        "estimates, listed in `orchestration/arm/geometry.toml`."
    )


def _budget(outcome: ArmOutcome) -> Table:
    coupling = outcome.coupling_error_um
    rows = [
        ("coupling error of any elongation", "unknown" if coupling is None else f"±{coupling:.2g} µm"),
        ("discretisation error of any elongation", f"±{outcome.discretisation_error_um:.2g} µm"),
    ]
    for axis, audit in zip(axes(), outcome.result.audits, strict=False):
        share = abs(audit.total) / max(abs(audit.delivered), 1e-12)
        rows.append((f"heat balance, {axis.name}", f"{audit.total:.3g} J ({share:.2g} of it)"))
    return Table(("", "at most"), rows)


def _settings(outcome: ArmOutcome) -> Table:
    scenario = outcome.scenario
    rows = [
        ("scenario", scenario.name),
        ("stop time", f"{scenario.stop_time:g} s"),
        ("communication step size", f"{scenario.step_size:g} s"),
        ("master algorithm", scenario.master),
        ("FMUs", outcome.fmus),
        ("controller of each axis", outcome.compensations[0].name),
        ("thermometer of each axis", f"{scenario.sensor}, {scenario.sensor_noise:g} K (1 sigma)"),
        ("tolerance", f"{1e6 * scenario.tolerance:g} µm"),
        *((name, str(value)) for name, value in scenario.parameters.items()),
        ("stepped in", f"{outcome.result.statistics.wall_seconds:.2f} s"),
        ("computed in", f"{outcome.wall_seconds:.2f} s"),
    ]
    return Table(("setting", "value"), rows)

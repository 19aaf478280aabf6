"""What the report of a scenario has for the arm besides."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warmlink.fmus.arm_kinematics.equations import COORDINATES
from warmlink.orchestration.arm.errors import ArmErrors, Workspace, by_name, columns, workspace
from warmlink.orchestration.arm.geometry import axes
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.closed_loop.outcome import ClosedLoop
from warmlink.orchestration.report.figures import Line, styled, time_plot
from warmlink.orchestration.report.page import Section, Table
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER
from warmlink.orchestration.system.units import ZERO_CELSIUS


def sections(outcome: ClosedLoop) -> list[Section]:
    """What a report has for the arm besides: where the error comes from, the workspace, the chain."""
    errors = ArmErrors(outcome.result)
    return [
        Section("Where it comes from, axis by axis", _AXES_TEXT, table=_axes_table(outcome, errors)),
        Section("Elongation of each link", figure=_axis_plot(outcome, errors.growth)),
        Section("What the compensation of each axis leaves", figure=_axis_plot(outcome, errors.left)),
        Section("Left over in x, y and z", figure=_coordinates_plot(outcome, errors)),
        *_maps(outcome, errors),
        Section("Shafts", figure=_temperature_plot(outcome, "motor.shaft_temperature")),
        Section("Links, half-way", figure=_temperature_plot(outcome, "link.sensor_temperature[2]")),
        Section("Heat along the chain", _CHAIN_TEXT, figure=_chain_plot(outcome)),
        Section("The arm's figures", _GEOMETRY_TEXT),
    ]


_GEOMETRY_TEXT = (
    "Masses, sections and conductances of the arm are estimates, listed in "
    "`orchestration/arm/geometry.toml`. The poses of a program go on through pauses, where they tell how far "
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


def _axes_table(outcome: ClosedLoop, errors: ArmErrors) -> Table:
    kinds = {NO_CONTROLLER: errors.growth, outcome.controller: errors.left}
    shares = [by_name(1e6 * errors.by_axis(each)) for each in kinds.values()]
    largest = by_name(1e6 * errors.growth.max(axis=0))
    left = by_name(1e6 * np.abs(errors.left).max(axis=0))
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
    return Table(
        ("axis", "growth, at most", "left of it, at most", *(f"adds: {name}" for name in kinds)), rows
    )


def _axis_plot(outcome: ClosedLoop, values: Array) -> object:
    lines = [Line(axis.name, 1e6 * values[:, i]) for i, axis in enumerate(axes())]
    return time_plot(outcome.time, lines, "length [µm]")


def _coordinates_plot(outcome: ClosedLoop, errors: ArmErrors) -> object:
    error = errors.tool_error(errors.left)
    return time_plot(
        outcome.time, [Line(name, 1e6 * error[:, k]) for k, name in enumerate(COORDINATES)], "error [µm]"
    )


def _temperature_plot(outcome: ClosedLoop, variable: str) -> object:
    values = columns(outcome.result, variable) - ZERO_CELSIUS
    lines = [Line(axis.name, values[:, i]) for i, axis in enumerate(axes())]
    lines.append(Line("surroundings", outcome.result["axis1.duty.ambient_temperature"] - ZERO_CELSIUS))
    return time_plot(outcome.time, lines, "temperature [°C]")


def _chain_plot(outcome: ClosedLoop) -> object:
    values = columns(outcome.result, "motor.neighbour_heat_flow")
    lines = [Line(axis.name, values[:, i]) for i, axis in enumerate(axes()) if i > 0]
    return time_plot(outcome.time, lines, "heat flow [W]")


def moments(outcome: ClosedLoop) -> list[int]:
    """Communication points of the maps: the worst, and an hour in, half-way and the end unless near it."""
    worst, last = int(np.argmax(np.abs(outcome.uncompensated_error))), len(outcome.time) - 1
    hour = int(np.searchsorted(outcome.time, min(3600.0, outcome.time[-1])))
    return sorted({worst, *(point for point in (hour, last // 2, last) if abs(point - worst) > last / 20)})


def _maps(outcome: ClosedLoop, errors: ArmErrors) -> list[Section]:
    grid = workspace()
    sections = []
    for heading, values, text in (
        ("Error over the workspace, uncompensated", errors.growth, _MAP_TEXT),
        (f"Error over the workspace, with {outcome.controller}", errors.left, ""),
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
    styled(figure, 440, 100 + 180 * len(points))
    # The titles stand below the buttons.
    return figure.update_layout(margin_t=90)

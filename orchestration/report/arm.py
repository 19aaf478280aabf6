"""What the report of the six-axis arm has besides: where the error comes from, by axis and by pose."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warmlink.fmus.arm_kinematics.equations import COORDINATES
from warmlink.orchestration.arm.chain import axes
from warmlink.orchestration.arm.errors import ArmErrors, Workspace, by_name, columns, workspace
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.closed_loop.outcome import ClosedLoop
from warmlink.orchestration.report.figures import styled, time_plot
from warmlink.orchestration.report.page import PageTable, Section
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER
from warmlink.orchestration.system.units import ZERO_CELSIUS


def sections(outcome: ClosedLoop) -> list[Section]:
    """Sections of the arm's report."""
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


def _axes_table(outcome: ClosedLoop, errors: ArmErrors) -> PageTable:
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
    return PageTable(("axis", "growth, at most", "left of it, at most", *adds), rows)


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

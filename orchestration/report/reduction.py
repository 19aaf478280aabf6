"""The pages of `warmlink reduce`: a part that can be turned, the errors of its model, and its faces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.reduction.order import AMBIENT_CHANGE, SAFETY, TIP_HEAT_FLOW
from warmlink.orchestration.reduction.part import HEAT_FLOW, NOISE, TIMES, Part, best_pair, tool_error, warmed
from warmlink.orchestration.reduction.solid import Integers, Solid
from warmlink.orchestration.report.figures import COLOURS, chart
from warmlink.orchestration.report.page import PageTable, Section, write_page

SHOWN = 0.05
"""Largest displacement in the picture, as a share of the part's extent."""

MOST_CORNERS = 3000
"""Of a drawn surface, so that a page stays small."""

THERMOMETER_PLACES = 100
"""Most corners of the surface at which a thermometer is tried."""


def remarks(part: Part, name: str) -> str:
    """What the documentation of a part's FMU says of it, in Markdown; `name` is that of its file."""
    sections = facts(part)
    return "\n\n".join([f"## This part: {name}", *(section.markdown() for section in sections)])


def facts(part: Part) -> list[Section]:
    """What is known of a part: how it is used, its error against the order, and against the mesh."""
    within, mesh, (heated, tool, *cooled) = part.within, part.mesh, part.elements.faces
    use = {"heated": heated, "tool": tool}
    use |= {f"cooled, `convection_factor[{i}]`": group for i, group in enumerate(cooled, 1)}
    met = "not met: the order was given" if part.error > 1 else "met"
    orders = [(str(tried.basis.shape[1]), f"{tried.error:.3g}") for tried in part.search]
    elongations = [
        *(
            (str(count), *(f"{1e6 * length:.4f}" for length in row))
            for count, row in zip(mesh.unknowns, mesh.elongation, strict=True)
        ),
        ("error [nm]", *(f"{1e9 * each:.2g}" for each in mesh.error)),
    ]
    return [
        Section(
            "Use and range",
            f"Mesh: {part.size}. Thermometers [mm]: {in_mm(part.elements.sensors)}. Range: conductivity "
            "{:.4g} to {:.4g} W/(m.K); ".format(*within.conductivity)
            + "convection and linearised radiation {:.4g} to {:.4g} W/(m2.K). ".format(*within.convection)
            + f"Tolerance ({met}): {1e9 * within.displacement:g} nm and {1e3 * within.temperature:g} mK for "
            f"{within.heat_flow:g} W at the base, {TIP_HEAT_FLOW:g} W at the tip or surroundings "
            f"{AMBIENT_CHANGE:g} K warmer, one at a time. Bounds contain a factor of safety of {SAFETY:g}.",
            PageTable(("use", "faces"), [(what, ", ".join(f.label for f in of)) for what, of in use.items()]),
        ),
        Section(
            "Error against order",
            f"Order {part.model.order}, reduced from {len(part.dense.loads)} patterns that span the "
            "responses. Largest estimated error of displacement, rotation and temperatures over its "
            "tolerance, as the search went:",
            PageTable(("order", "error / tolerance"), orders),
        ),
        Section(
            "Mesh",
            f"Elongation [µm] after a step of {HEAT_FLOW:g} W on meshes of so many temperatures, the one in "
            f"use last ({mesh.observed}), and its estimated error [nm]. For a mesh file the first line is "
            "that of temperatures that are linear in each tetrahedron.",
            PageTable(("temperatures", *(f"{time:g} s" for time in TIMES)), elongations),
        ),
    ]


def write_report(part: Part, name: str, path: Path) -> None:
    """Write the page of a reduced part; `name` is that of its file."""
    solid, (use, order, mesh) = part.elements.solid.mesh, facts(part)
    lead = (
        f"{len(part.patterns)} temperatures of the finite elements become {part.model.order}, with an "
        f"estimated error of {100 * part.error:.0f} % of the tolerance. The mesh's own error is "
        f"{1e9 * part.mesh.error[-1]:.2g} nm of {1e6 * part.mesh.elongation[-1, -1]:.4g} µm."
    )
    tried = {"x": [each.basis.shape[1] for each in part.search], "y": [each.error for each in part.search]}
    errors = {"title": "error / tolerance", "type": "log", "exponentformat": "power"}
    x = {"title": "order", "dtick": 2}
    orders = chart({**tried, "mode": "lines+markers"}, x=x, y=errors, height=320)
    orders.add_hline(y=1.0, line_dash="dash", annotation_text="tolerance")
    surface = solid.facets[:, solid.boundary_facets()]
    thermometers, best = _thermometers(part, surface)
    shown = [_warming(part, surface, best), thermometers, use, replace(order, figure=orders), mesh]
    write_page(path, f"{name}, reduced", lead, shown)


def write_faces(solid: Solid, name: str, path: Path) -> None:
    """Write the page that shows a part's faces and their numbers; `name` is that of its file."""
    traces, marks, all_corners = [], [], solid.mesh.p
    for face in solid.faces:
        facets = solid.mesh.facets[:, face.facets]
        kept, triangles = _coarsened(all_corners, facets, max(MOST_CORNERS // len(solid.faces), 50))
        colour, told = COLOURS[(face.number - 1) % len(COLOURS)], f"{face.label} {1e6 * face.area:.4g} mm2"
        look = {"color": colour, "hovertext": told, "hoverinfo": "text"}
        traces.append(_surface(all_corners[:, kept], triangles, **look))
        # The centre need not lie on the face: its number stands at the corner nearest to it.
        corners = all_corners[:, np.unique(facets)].T
        marks.append(corners[np.argmin(np.linalg.norm(corners - face.centre, axis=1))])
    labels = [f"#{face.number}" for face in solid.faces]
    traces.append(_points(np.array(marks), labels, COLOURS[5], "faces"))
    section = Section("Turn it with the mouse", figure=_turned(traces))
    heat, tool, cooled = map(argument, ("heat_faces", "tool_faces", "cooled"))
    write_page(path, f"Faces of {name}", f"{heat}, {tool} and {cooled} take these.", [section])


def _warming(part: Part, surface: Integers, best: Array) -> Section:
    """The surface after a step of heat flow, from its elements and its heat in their span."""
    elements = part.elements
    rises = (part.patterns @ warmed(part.dense, part.within)).T
    moved = part.within.material["expansion_coefficient"] * elements.displacements(rises)
    # Corners come before the middles of edges.
    kept, triangles = _coarsened(elements.solid.mesh.p, surface, MOST_CORNERS)
    corners, rises, moved = elements.solid.mesh.p[:, kept], rises[:, kept], moved[:, :, kept]
    largest = float(np.linalg.norm(moved, axis=1).max())
    wanted = SHOWN * float(np.ptp(corners, axis=1).max()) / largest
    power = 10 ** np.floor(np.log10(wanted))
    times = power * max(each for each in (1, 2, 5) if each * power <= wanted)
    look = {
        "cmin": 0.0,
        "cmax": float(rises.max()),
        "colorscale": "Inferno",
        "colorbar": {"title": "K", "thickness": 14},
        "hovertemplate": "%{intensity:.3f} K above the start<extra></extra>",
    }
    traces = []
    for time, rise, displaced in zip(TIMES, rises.astype(np.float32), moved, strict=True):
        look |= {"intensity": rise, "visible": time == TIMES[-1]}
        traces.append(_surface(corners + times * displaced, triangles, **look))
    numbers = [str(i) for i in range(1, len(elements.sensors) + 1)]
    points = [
        _points(elements.sensors, numbers, COLOURS[7], "thermometers"),
        _points(best, ["best", "best"], COLOURS[2], "best two thermometers"),
        _points(elements.tool_point[None], ["tool point"], COLOURS[0], "tool point"),
    ]
    steps = []
    for time in TIMES:
        visible = [time == each for each in TIMES] + [True] * len(points)
        steps.append({"method": "restyle", "label": f"{time:g} s", "args": ["visible", visible]})
    sliders = [{"active": len(TIMES) - 1, "steps": steps, "pad": {"t": 10}}]
    return Section(
        "The part as it warms up",
        f"After a step of {HEAT_FLOW:g} W into the heated face of the cold part, at the middle of the range "
        f"of convection. Displacements, at most {1e6 * largest:.3g} µm, are relative to the heated face and "
        f"drawn {times:,.0f} times as large as they are.",
        figure=_turned([*traces, *points], sliders=sliders),
    )


def _thermometers(part: Part, surface: Integers) -> tuple[Section, Array]:
    """What thermometers tell of the tool point, and where the best two are, shape (2, 3) [m]."""
    corners = part.elements.solid.mesh.p
    places, _ = _coarsened(corners, surface, THERMOMETER_PLACES)
    error, ends = tool_error(part.model), part.model.loads[:, :2].T
    pair, least = best_pair(error, part.patterns[places] @ part.basis)
    best = corners[:, places[pair]].T
    compared = (
        ("the best two", in_mm(best), least),
        ("means over the heated face and the tool's", "", error(ends)),
        ("the heated face alone", "", error(ends[:1])),
    )
    section = Section(
        "Where two thermometers tell most of the tool point",
        "Error of the tool point (1 sigma) that an observer is left with whose thermometers have a noise of "
        f"{NOISE:g} K, and which knows the motor's heat and the air as little as `warmlink design` assumes. "
        f"Tried: pairs of {len(places)} places on the surface.",
        PageTable(
            ("thermometers", "at [mm]", "tool point"),
            [(what, at, f"{1e6 * left:.3g} µm") for what, at, left in compared],
        ),
    )
    return section, best


def _coarsened(corners: Array, triangles: Integers, most: int) -> tuple[Integers, Integers]:
    """Surface of corners, shape (3, n), with fewer: those in one cell of a grid become one.

    The numbers of the corners that stay, and triangles by the number among these (J. Rossignac and P. Borrel
    in *Modeling in Computer Graphics*, Springer 1993).
    """
    used, place = np.unique(triangles, return_inverse=True)
    cell = float(np.ptp(corners, axis=1).max()) / 1e4
    while True:
        cells = np.round(corners[:, used] / cell).astype(np.int64)
        _, first, owner = np.unique(cells, axis=1, return_index=True, return_inverse=True)
        if len(first) <= most:
            a, b, c = merged = owner.ravel()[place].reshape(triangles.shape)
            return used[first], merged[:, (a != b) & (b != c) & (a != c)]
        cell *= 1.2


def _surface(corners: Array, triangles: Integers, **look: Any) -> dict[str, Any]:
    x, y, z = (1e3 * corners).astype(np.float32)
    i, j, k = triangles.astype(np.int32)
    return dict(type="mesh3d", x=x, y=y, z=z, i=i, j=j, k=k, flatshading=True, **look)


def _points(places: Array, labels: Sequence[str], colour: str, name: str) -> dict[str, Any]:
    x, y, z = 1e3 * places.T
    look = {"mode": "markers+text", "marker": {"size": 4, "color": colour}}
    return dict(type="scatter3d", x=x, y=y, z=z, text=list(labels), name=name, **look)


def _turned(traces: Sequence[dict[str, Any]], **layout: Any) -> Any:
    axis = {"title": "", "ticksuffix": " mm"}
    camera = {"projection": {"type": "orthographic"}, "eye": {"x": 0.4, "y": -1.0, "z": 0.6}}
    scene = {"aspectmode": "data", "camera": camera, "xaxis": axis, "yaxis": axis, "zaxis": axis}
    return chart(*traces, height=560, scene=scene, **layout)


def in_mm(places: Array) -> str:
    """Places, shape (n, 3) [m], in mm as text."""
    return "; ".join(", ".join(f"{x:.4g}" for x in place) for place in 1e3 * places.round(5) + 0.0)

"""The pages of `warmlink reduce`: a part that can be turned, the errors of its model, and its faces."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.reduction.mesh_error import HEAT_FLOW, TIMES, warmed
from warmlink.orchestration.reduction.order import SAFETY
from warmlink.orchestration.reduction.part import Part
from warmlink.orchestration.reduction.solid import Solid
from warmlink.orchestration.reduction.surface import Integers, coarsened
from warmlink.orchestration.reduction.thermometers import NOISE, Observer, best_pair
from warmlink.orchestration.report.figures import COLOURS, chart
from warmlink.orchestration.report.page import Section, Table, write_page

SHOWN = 0.05
"""Largest displacement in the picture, as a share of the part's extent."""

MOST_CORNERS = 3000
"""Of a drawn surface, so that a page stays small."""

THERMOMETER_PLACES = 100
"""Most corners of the surface at which a thermometer is tried."""


def write_report(part: Part, name: str, path: Path) -> None:
    """Write the page of a reduced part; `name` is that of its file."""
    mesh = part.mesh
    lead = (
        f"{part.heat.unknowns} temperatures of the finite elements become {part.model.order}, with an "
        f"estimated error of {100 * part.chosen.error:.0f} % of the tolerance. The mesh's own error is "
        f"{1e9 * mesh.error[-1]:.2g} nm of {1e6 * mesh.elongation[-1, -1]:.4g} µm."
    )
    surface = part.solid.mesh.facets[:, part.solid.mesh.boundary_facets()]
    places, _ = coarsened(part.solid.mesh.p, surface, THERMOMETER_PLACES)
    observer = Observer(part.model)
    pair, error = best_pair(observer, part.patterns[places] @ part.basis)
    best = part.solid.mesh.p[:, places[pair]].T
    orders = chart(
        {
            "x": [tried.order for tried in part.search],
            "y": [tried.error for tried in part.search],
            "mode": "lines+markers",
        },
        x={"title": "order", "dtick": 2},
        y={"title": "error / tolerance", "type": "log", "exponentformat": "power"},
        height=320,
    )
    orders.add_hline(y=1.0, line_dash="dash", annotation_text="tolerance")
    sections = [
        _warming(part, surface, best),
        _thermometers(part, observer, best, error, len(places)),
        Section(
            "Error against order",
            "Largest estimated error of displacement, rotation and temperatures over its tolerance, with a "
            f"factor of safety of {SAFETY:g}, as the search went.",
            figure=orders,
        ),
        Section("Mesh", mesh.sentence, table=Table(*mesh.table)),
    ]
    write_page(path, f"{name}, reduced", lead, sections)


def write_faces(solid: Solid, name: str, path: Path) -> None:
    """Write the page that shows a part's faces and their numbers; `name` is that of its file."""
    traces, marks, all_corners = [], [], solid.mesh.p
    for face in solid.faces:
        facets = solid.mesh.facets[:, face.facets]
        kept, triangles = coarsened(all_corners, facets, max(MOST_CORNERS // len(solid.faces), 50))
        label = f"{face.label} {1e6 * face.area:.4g} mm2"
        colour = COLOURS[(face.number - 1) % len(COLOURS)]
        look = {"color": colour, "hovertext": label, "hoverinfo": "text"}
        traces.append(_surface(all_corners[:, kept], triangles, **look))
        # The centre need not lie on the face: its number stands at the corner nearest to it.
        corners = all_corners[:, np.unique(facets)]
        away = np.linalg.norm(corners - face.centre[:, None], axis=0)
        marks.append(corners[:, np.argmin(away)])
    labels = [f"#{face.number}" for face in solid.faces]
    traces.append(_points(np.array(marks), labels, COLOURS[5], "faces"))
    section = Section("Turn it with the mouse", figure=_turned(traces))
    write_page(path, f"Faces of {name}", "--heat-face, --tool-face and --cooled take these.", [section])


def _warming(part: Part, surface: Integers, best: Array) -> Section:
    """The surface after a step of heat flow, from its elements and its heat in their span."""
    rises = (part.patterns @ warmed(part.dense, part.within)).T
    moved = part.within.material["expansion_coefficient"] * part.elements.displacements(rises)
    # Corners come before the middles of edges.
    kept, triangles = coarsened(part.solid.mesh.p, surface, MOST_CORNERS)
    corners, rises, moved = part.solid.mesh.p[:, kept], rises[:, kept], moved[:, :, kept]
    extent, largest = float(np.ptp(corners, axis=1).max()), float(np.linalg.norm(moved, axis=1).max())
    # One, two or five times a power of ten.
    power = 10 ** np.floor(np.log10(SHOWN * extent / largest))
    times = power * max(each for each in (1, 2, 5) if each * power <= SHOWN * extent / largest)
    traces = [
        _surface(
            corners + times * displaced,
            triangles,
            intensity=rise.astype(np.float32),
            cmin=0.0,
            cmax=float(rises.max()),
            colorscale="Inferno",
            colorbar={"title": "K", "thickness": 14},
            hovertemplate="%{intensity:.3f} K above the start<extra></extra>",
            visible=time == TIMES[-1],
        )
        for time, rise, displaced in zip(TIMES, rises, moved, strict=True)
    ]
    task = part.task
    points = [
        _points(task.sensors, list(map(str, range(1, len(task.sensors) + 1))), COLOURS[7], "thermometers"),
        _points(best, ["best", "best"], COLOURS[2], "best two thermometers"),
        _points(task.tool_point[None], ["tool point"], COLOURS[0], "tool point"),
    ]
    steps = [
        {
            "method": "restyle",
            "label": f"{time:g} s",
            "args": ["visible", [time == each for each in TIMES] + [True] * len(points)],
        }
        for time in TIMES
    ]
    return Section(
        "The part as it warms up",
        f"After a step of {HEAT_FLOW:g} W into the heated face of the cold part, at the middle of the range "
        f"of convection. Displacements, at most {1e6 * largest:.3g} µm, are relative to the heated face and "
        f"drawn {times:,.0f} times as large as they are.",
        figure=_turned(
            [*traces, *points], sliders=[{"active": len(TIMES) - 1, "steps": steps, "pad": {"t": 10}}]
        ),
    )


def _thermometers(part: Part, observer: Observer, best: Array, error: float, tried: int) -> Section:
    ends = np.array([part.model.base_row, part.model.tip_row])
    at = "; ".join(", ".join(f"{1e3 * x:.4g}" for x in place) for place in best.round(7))
    rows = [
        ("the best two", at, error),
        ("means over the heated face and the tool's", "", observer.error(ends)),
        ("the heated face alone", "", observer.error(ends[:1])),
    ]
    return Section(
        "Where two thermometers tell most of the tool point",
        "Error of the tool point (1 sigma) that an observer is left with whose thermometers have a noise of "
        f"{NOISE:g} K, and which knows the motor's heat and the air as little as `warmlink design` assumes. "
        f"Tried: pairs of {tried} places on the surface.",
        table=Table(
            ("thermometers", "at [mm]", "tool point"),
            [(what, places, f"{1e6 * error:.3g} µm") for what, places, error in rows],
        ),
    )


def _surface(corners: Array, triangles: Integers, **look: Any) -> dict[str, Any]:
    x, y, z = (1e3 * corners).astype(np.float32)
    i, j, k = triangles.astype(np.int32)
    places = {"x": x, "y": y, "z": z, "i": i, "j": j, "k": k}
    return {"type": "mesh3d", **places, "flatshading": True, **look}


def _points(places: Array, labels: Sequence[str], colour: str, name: str) -> dict[str, Any]:
    x, y, z = 1e3 * places.T
    marks = {"text": list(labels), "mode": "markers+text", "marker": {"size": 4, "color": colour}}
    return {"type": "scatter3d", "x": x, "y": y, "z": z, **marks, "name": name}


def _turned(traces: Sequence[dict[str, Any]], **layout: Any) -> Any:
    axis = {"title": "", "ticksuffix": " mm"}
    camera = {"projection": {"type": "orthographic"}, "eye": {"x": 0.4, "y": -1.0, "z": 0.6}}
    scene = {"aspectmode": "data", "camera": camera, "xaxis": axis, "yaxis": axis, "zaxis": axis}
    return chart(*traces, height=560, scene=scene, **layout)

"""The pages of `warmlink reduce`: a part that can be turned, the errors of its model, and its faces."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.reduction.mesh_error import HEAT_FLOW, TIMES
from warmlink.orchestration.reduction.order import SAFETY
from warmlink.orchestration.reduction.part import Part
from warmlink.orchestration.reduction.picture import MOST_CORNERS
from warmlink.orchestration.reduction.remarks import mesh_sentence, mesh_table
from warmlink.orchestration.reduction.simplices import coarsened
from warmlink.orchestration.reduction.solid import Face, Solid
from warmlink.orchestration.reduction.thermometers import NOISE, Observer, Pair, best_pair
from warmlink.orchestration.report.figures import COLOURS, styled
from warmlink.orchestration.report.page import Section, Table, versions, write_page

SHOWN = 0.05
"""Largest displacement in the picture, as a share of the part's extent."""


def write_report(part: Part, name: str, path: Path) -> None:
    """Write the page of a reduced part; `name` is that of its file."""
    mesh = part.mesh
    lead = (
        f"{part.heat.unknowns} temperatures of the finite elements become {part.model.order}, with an "
        f"estimated error of {100 * part.chosen.error:.0f} % of the tolerance. The mesh's own error is "
        f"{1e9 * mesh.error[-1]:.2g} nm of {1e6 * mesh.elongation[-1, -1]:.4g} µm."
    )
    observer = Observer(part.model)
    best = best_pair(observer, part.places, part.rows)
    sections = [
        _part(part, best),
        _thermometers(part, observer, best),
        Section(
            "Error against order",
            "Largest estimated error of displacement, rotation and temperatures over its tolerance, with a "
            f"factor of safety of {SAFETY:g}, as the search went.",
            figure=_orders(part.chosen.orders, part.chosen.errors),
        ),
        Section("Mesh", mesh_sentence(mesh), table=Table(*mesh_table(mesh))),
        Section("Software", table=versions()),
    ]
    write_page(path, f"{name}, reduced", lead, sections)


def write_faces(solid: Solid, name: str, path: Path) -> None:
    """Write the page that shows a part's faces and their numbers; `name` is that of its file."""
    import plotly.graph_objects as go

    figure = go.Figure()
    share = max(MOST_CORNERS // len(solid.faces), 50)
    for face in solid.faces:
        corners, triangles = _surface(solid, face, share)
        colour = COLOURS[(face.number - 1) % len(COLOURS)]
        figure.add_trace(_mesh(corners, triangles, color=colour, hovertext=_label(face), hoverinfo="text"))
    places = 1e3 * np.array([_on(solid, face) for face in solid.faces]).T
    labels = [f"#{face.number}" for face in solid.faces]
    figure.add_trace(_points(places, labels, COLOURS[5], "faces"))
    section = Section("Turn it with the mouse", figure=_turned(figure))
    write_page(path, f"Faces of {name}", "--heat-face, --tool-face and --cooled take these.", [section])


def _part(part: Part, best: Pair) -> Section:
    import plotly.graph_objects as go

    picture = part.picture
    extent = float(np.ptp(picture.corners, axis=1).max())
    largest = float(np.linalg.norm(picture.displacements, axis=1).max())
    # One, two or five times a power of ten.
    power = 10 ** np.floor(np.log10(SHOWN * extent / largest))
    times = power * max(each for each in (1, 2, 5) if each * power <= SHOWN * extent / largest)
    figure = go.Figure()
    top = float(picture.rises.max())
    for i, (rise, moved) in enumerate(zip(picture.rises, picture.displacements, strict=True)):
        figure.add_trace(
            _mesh(
                picture.corners + times * moved,
                picture.triangles,
                intensity=rise.astype(np.float32),
                cmin=0.0,
                cmax=top,
                colorscale="Inferno",
                colorbar={"title": "K", "thickness": 14},
                hovertemplate="%{intensity:.3f} K above the start<extra></extra>",
                visible=i == len(TIMES) - 1,
            )
        )
    points = [
        (
            "thermometers",
            part.task.sensors,
            [str(i) for i in range(1, len(part.task.sensors) + 1)],
            COLOURS[7],
        ),
        ("best two thermometers", best.places, ["best", "best"], COLOURS[2]),
        ("tool point", part.task.tool_point[None], ["tool point"], COLOURS[0]),
    ]
    for title, places, labels, colour in points:
        figure.add_trace(_points(1e3 * places.T, labels, colour, title))
    shown = [[i == j for i in range(len(TIMES))] + [True] * len(points) for j in range(len(TIMES))]
    steps = [
        {"method": "restyle", "label": f"{time:g} s", "args": ["visible", seen]}
        for time, seen in zip(TIMES, shown, strict=True)
    ]
    figure.update_layout(sliders=[{"active": len(TIMES) - 1, "steps": steps, "pad": {"t": 10}}])
    return Section(
        "The part as it warms up",
        f"After a step of {HEAT_FLOW:g} W into the heated face of the cold part, at the middle of the range "
        f"of convection. Displacements, at most {1e6 * largest:.3g} µm, are relative to the heated face and "
        f"drawn {times:,.0f} times as large as they are.",
        figure=_turned(figure),
    )


def _thermometers(part: Part, observer: Observer, best: Pair) -> Section:
    model = part.model
    ends = np.array([model.base_row, model.tip_row])
    rows = [
        ("the best two", _millimetres(best.places), best.error),
        ("means over the heated face and the tool's", "", observer.error(ends)),
        ("the heated face alone", "", observer.error(ends[:1])),
    ]
    return Section(
        "Where two thermometers tell most of the tool point",
        "Error of the tool point (1 sigma) that an observer is left with whose thermometers have a noise of "
        f"{NOISE:g} K, and which knows the motor's heat and the air as little as `warmlink design` assumes. "
        f"Tried: pairs of {len(part.places)} places on the surface.",
        table=Table(
            ("thermometers", "at [mm]", "tool point"),
            [(what, places, f"{1e6 * error:.3g} µm") for what, places, error in rows],
        ),
    )


def _orders(orders: Sequence[int], errors: Sequence[float]) -> Any:
    import plotly.graph_objects as go

    figure = go.Figure(go.Scatter(x=list(orders), y=list(errors), mode="lines+markers"))
    figure.add_hline(y=1.0, line_dash="dash", annotation_text="tolerance")
    figure.update_xaxes(title="order", dtick=2)
    figure.update_yaxes(title="error / tolerance", type="log", exponentformat="power")
    return styled(figure, 320)


def _surface(solid: Solid, face: Face, most: int) -> tuple[Array, NDArray[np.int64]]:
    kept, triangles = coarsened(solid.mesh.p, solid.mesh.facets[:, face.facets], most)
    return solid.mesh.p[:, kept], triangles


def _on(solid: Solid, face: Face) -> Array:
    """Corner of a face that is nearest to its centre, which need not lie on it."""
    corners = solid.mesh.p[:, np.unique(solid.mesh.facets[:, face.facets])]
    return np.asarray(corners[:, np.argmin(np.linalg.norm(corners - face.centre[:, None], axis=0))])


def _label(face: Face) -> str:
    return f"#{face.number} {face.name} {1e6 * face.area:.4g} mm2".replace("  ", " ")


def _mesh(corners: Array, triangles: NDArray[np.int64], **look: Any) -> Any:
    import plotly.graph_objects as go

    x, y, z = (1e3 * corners).astype(np.float32)
    i, j, k = triangles.astype(np.int32)
    return go.Mesh3d(x=x, y=y, z=z, i=i, j=j, k=k, flatshading=True, **look)


def _points(places: Array, labels: Sequence[str], colour: str, name: str) -> Any:
    import plotly.graph_objects as go

    x, y, z = places
    return go.Scatter3d(
        x=x,
        y=y,
        z=z,
        text=list(labels),
        mode="markers+text",
        marker={"size": 4, "color": colour},
        name=name,
    )


def _turned(figure: Any) -> Any:
    axis = {"title": "", "ticksuffix": " mm"}
    camera = {"projection": {"type": "orthographic"}, "eye": {"x": 0.4, "y": -1.0, "z": 0.6}}
    scene = {"aspectmode": "data", "camera": camera, "xaxis": axis, "yaxis": axis, "zaxis": axis}
    return styled(figure, 560).update_layout(scene=scene)


def _millimetres(places: Array) -> str:
    return "; ".join(", ".join(f"{1e3 * x:.4g}" for x in place) for place in np.round(places, 7))

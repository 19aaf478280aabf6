"""The content of the paper's Figures 2 to 8, computed; its own curves are pictures and are not drawn."""

from __future__ import annotations

from typing import Any

import numpy as np

from warmlink.orchestration.paper.cases import CaseResult, front_profile
from warmlink.orchestration.paper.data import GEOMETRY, PAPER
from warmlink.orchestration.paper.reproduce import Reproduction
from warmlink.orchestration.report.figures import chart, styled, time_plot
from warmlink.orchestration.system.units import ZERO_CELSIUS

FEA, LINK, BLACK, PALE = "#0b5d9c", "#d9730d", "#111111", "#c9d2d9"

MAGNIFICATION = 100.0
"""Displacements are drawn so many times larger, as in Figure 7 of the paper."""

WIDE: dict[str, Any] = {"height": 440, "least_width": 500, "margin_t": 60}


def figures(result: Reproduction) -> dict[str, Any]:
    """Draw every figure; the keys are headings."""
    still, moving = result.cases["stationary"], result.cases["moving"]
    return {
        "Temperature along the link after an hour (Figures 2 and 4)": _steady_profiles(still, moving),
        "Stationary case: temperature (Figure 3)": _temperatures(still),
        "Stationary case: elongation (Figure 3)": _elongations(still),
        "Moving case: temperature (Figure 5)": _temperatures(moving).add_traces(
            _printed([60.0, 60.0], "base", "tip")
        ),
        "Moving case: temperature after an hour, fringe plot (Figure 6)": _fringe_plot(moving),
        "Moving case: deformed link, displacement x 100 (Figure 7)": _deformed_link(moving),
        "Moving case: elongation (Figure 8)": _elongations(moving).add_traces(_printed([60.0], "elongation")),
        "What was tried: elongation after an hour": _attempts_chart(result),
    }


def _steady_profiles(*cases: CaseResult) -> Any:
    """Temperature over position for both cases, with the temperatures that the paper prints."""
    places = 1e3 * np.linspace(GEOMETRY.shaft_centre, GEOMETRY.diode_centre, 3)
    traces = []
    for result, dash, symbol in zip(cases, ("dot", "solid"), ("circle-open", "circle"), strict=True):
        x, temperature = front_profile(result)
        link = [result.link.end(where) for where in ("base", "middle", "tip")]
        name, line = f"3-D FEA, {result.case.name}", {"color": FEA, "dash": dash}
        traces.append({"x": x * 1e3, "y": temperature - ZERO_CELSIUS, "name": name, "line": line})
        name, marker = f"1-D link, {result.case.name}", {"color": LINK, "symbol": symbol, "size": 9}
        traces.append({"x": places, "y": link, "name": name, "mode": "markers", "marker": marker})
    traces += _printed([places[0], places[2]], "base", "tip")
    return chart(*traces, x="position along the link [mm]", y="temperature [°C]", **WIDE)


def _fringe_plot(moving: CaseResult) -> Any:
    """Outer surface of link, shaft and diode, coloured in bands of temperature."""
    from plotly.colors import sample_colorscale

    mesh = moving.body.mesh
    x, y, z = mesh.p * 1e3
    # Two triangles for each outer facet, whose nodes go around it.
    a, b, c, d = mesh.facets[:, mesh.boundary_facets()]
    i, j, k = np.hstack([[a, b, c], [a, c, d]])
    colours = sample_colorscale("Turbo", np.linspace(0.05, 0.95, 10).tolist())
    surface = {
        **{"type": "mesh3d", "x": x, "y": y, "z": z, "i": i, "j": j, "k": k},
        "intensity": moving.final - ZERO_CELSIUS,
        "colorscale": [(edge / 10, colour) for n, colour in enumerate(colours) for edge in (n, n + 1)],
        "flatshading": True,
        "colorbar": {"title": "°C"},
        "lighting": {"ambient": 0.75, "diffuse": 0.4, "specular": 0.0},
        "hovertemplate": "%{intensity:.1f} °C<extra></extra>",
    }
    scene = {
        "aspectmode": "data",
        "xaxis": {"title": "", "ticksuffix": " mm"},
        "yaxis": {"visible": False},
        "zaxis": {"visible": False},
        "camera": {"eye": {"x": 0.13, "y": -0.85, "z": 0.47}, "projection": {"type": "orthographic"}},
    }
    return chart(surface, scene=scene, **WIDE)


def _deformed_link(moving: CaseResult) -> Any:
    """Front of the link in plan, undeformed and with its displacement magnified."""
    mesh = moving.body.mesh
    on_face = np.all(np.abs(mesh.p[2][mesh.facets] - GEOMETRY.thickness) < 1e-7, axis=0)
    around = mesh.facets[[0, 1, 2, 3, 0]][:, on_face]
    traces = []
    for name, points, colour in (
        ("undeformed", mesh.p, PALE),
        ("deformed", mesh.p + MAGNIFICATION * moving.displacement, FEA),
    ):
        # Outlines of the facets as one line, broken by NaN.
        x, y, _ = np.pad(1e3 * points[:, around], ((0, 0), (0, 1), (0, 0)), constant_values=np.nan)
        line = {"color": colour, "width": 1}
        traces.append({"x": x.T.ravel(), "y": y.T.ravel(), "name": name, "mode": "lines", "line": line})
    across = {"title": "x [mm]", "range": [-10, 1e3 * GEOMETRY.length + 20]}
    return chart(*traces, x=across, y={"title": "y [mm]", "scaleanchor": "x", "scaleratio": 1}, **WIDE)


def _attempts_chart(result: Reproduction) -> Any:
    """Elongation after an hour by every attempt, beside what was measured."""
    from plotly.subplots import make_subplots

    figure = make_subplots(
        rows=1, cols=2, subplot_titles=("stationary [µm]", "moving [µm]"), shared_yaxes=True
    )
    measured = {"mode": "lines", "name": "measured", "line": {"color": BLACK, "dash": "dash"}}
    look = {"orientation": "h", "marker_color": FEA, "showlegend": False, "cliponaxis": False}
    for column, case in enumerate(result.cases, start=1):
        attempts = {a.name: a.elongation for a in result.attempts if a.case == case}
        names, lengths = list(attempts)[::-1], list(attempts.values())[::-1]
        place, told = {"row": 1, "col": column}, [f"{length:.1f}" for length in lengths]
        figure.add_bar(x=lengths, y=names, text=told, textposition="outside", **look, **place)
        figure.update_xaxes(range=[0, 1.15 * max(lengths)], **place)
        figure.add_vline(x=PAPER[case]["elongation_measured"].value, line=measured["line"], **place)
        figure.add_scatter(x=[None], y=[None], showlegend=column == 1, **measured, **place)
    return styled(figure, WIDE["height"], WIDE["least_width"]).update_layout(margin_t=60)


def _printed(x: list[float], *quantities: str) -> list[dict[str, Any]]:
    traces: list[dict[str, Any]] = []
    for kind, symbol in (("measured", "x"), ("predicted", "cross")):
        y = [PAPER["moving"][f"{quantity}_{kind}"].value for quantity in quantities]
        look = {
            "mode": "markers",
            "cliponaxis": False,
            "marker": {"color": BLACK, "symbol": symbol, "size": 10},
        }
        traces.append({"type": "scatter", "x": x, "y": y, "name": f"paper, moving, {kind}", **look})
    return traces


def _temperatures(result: CaseResult) -> Any:
    lines = {
        f"{name}, above the {place}": history.temperature[where] - ZERO_CELSIUS
        for name, history in (("3-D FEA", result.fea), ("1-D link", result.link))
        for where, place in (("base", "shaft"), ("tip", "diode"))
    }
    return time_plot(result.fea.time, lines, "temperature [°C]", height=WIDE["height"])


def _elongations(result: CaseResult) -> Any:
    lines = {
        "3-D FEA": result.fea.elongation * 1e6,
        "1-D link": result.link.elongation * 1e6,
        "corrected Eq. (4)": result.corrected * 1e6,
        # As printed it begins beyond all bounds.
        "Eq. (4) as printed": np.minimum(result.printed * 1e6, 1.3 * result.corrected.max() * 1e6),
    }
    return time_plot(result.fea.time, lines, "elongation [µm]", height=WIDE["height"])

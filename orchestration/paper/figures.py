"""The content of the paper's Figures 2 to 8, computed; its own curves are pictures and are not drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from warmlink.orchestration.paper.data import load_geometry, load_paper
from warmlink.orchestration.paper.results import CaseResult, Reproduction
from warmlink.orchestration.paper.statements import front_profile
from warmlink.orchestration.report.figures import Line, styled, time_plot
from warmlink.orchestration.system.units import ZERO_CELSIUS

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

FEA, LINK, PAPER, PALE = "#0b5d9c", "#d9730d", "#111111", "#c9d2d9"
#: Displacements are drawn so many times larger, as in Figure 7 of the paper.
MAGNIFICATION = 100.0
HEIGHT = 440


def figures(result: Reproduction) -> dict[str, Figure]:
    """Draw every figure; the keys are headings."""
    still, moving = result.cases["stationary"], result.cases["moving"]
    return {
        "Temperature along the link after an hour (Figures 2 and 4)": steady_profiles(still, moving),
        "Stationary case: temperature (Figure 3)": _temperatures(still),
        "Stationary case: elongation (Figure 3)": _elongations(still),
        "Moving case: temperature (Figure 5)": _printed(_temperatures(moving), [60.0, 60.0], "base", "tip"),
        "Moving case: temperature after an hour, fringe plot (Figure 6)": fringe_plot(moving),
        "Moving case: deformed link, displacement x 100 (Figure 7)": deformed_link(moving),
        "Moving case: elongation (Figure 8)": _printed(_elongations(moving), [60.0], "elongation"),
        "What was tried: elongation after an hour": attempts_chart(result),
    }


def steady_profiles(still: CaseResult, moving: CaseResult) -> Figure:
    """Temperature over position for both cases, with the temperatures that the paper prints."""
    from plotly import graph_objects as go

    figure = go.Figure()
    g = load_geometry()
    for result, dash in ((still, "dot"), (moving, "solid")):
        x, temperature = front_profile(result)
        name = f"3-D FEA, {result.case.name}"
        figure.add_scatter(
            x=x * 1e3, y=temperature - ZERO_CELSIUS, name=name, line={"color": FEA, "dash": dash}
        )
        places = [g.shaft_centre, g.shaft_centre + g.span / 2, g.diode_centre]
        link = [result.link.temperature[w][-1] - ZERO_CELSIUS for w in ("base", "middle", "tip")]
        figure.add_scatter(
            x=np.array(places) * 1e3, y=link, name=f"1-D link, {result.case.name}", mode="markers",
            marker={"color": LINK, "symbol": "circle" if dash == "solid" else "circle-open", "size": 9},
        )  # fmt: skip
    _printed(figure, [g.shaft_centre * 1e3, g.diode_centre * 1e3], "base", "tip")
    return _dressed(figure, "position along the link [mm]", "temperature [°C]")


def fringe_plot(moving: CaseResult) -> Figure:
    """Outer surface of link, shaft and diode, coloured in bands of temperature."""
    from plotly import graph_objects as go

    temperature = moving.fea.final - ZERO_CELSIUS
    x, y, z = moving.body.mesh.p * 1e3
    mesh = moving.body.mesh
    # Two triangles for each outer facet, whose nodes go around it.
    a, b, c, d = mesh.facets[:, mesh.boundary_facets()]
    i, j, k = np.hstack([[a, b, c], [a, c, d]])
    figure = go.Figure(
        go.Mesh3d(
            x=x, y=y, z=z, i=i, j=j, k=k, intensity=temperature, colorscale=_bands(10), flatshading=True,
            colorbar={"title": "°C"}, lighting={"ambient": 0.75, "diffuse": 0.4, "specular": 0.0},
            hovertemplate="%{intensity:.1f} °C<extra></extra>",
        )
    )  # fmt: skip
    figure.update_layout(
        scene={
            "aspectmode": "data",
            "xaxis": {"title": "", "ticksuffix": " mm"},
            "yaxis": {"visible": False},
            "zaxis": {"visible": False},
            "camera": {"eye": {"x": 0.13, "y": -0.85, "z": 0.47}, "projection": {"type": "orthographic"}},
        }
    )
    return _dressed(figure, None, None)


def deformed_link(moving: CaseResult) -> Figure:
    """Front of the link in plan, undeformed and with its displacement magnified."""
    from plotly import graph_objects as go

    mesh = moving.body.mesh
    on_face = np.all(np.abs(mesh.p[2][mesh.facets] - load_geometry().thickness) < 1e-7, axis=0)
    around = mesh.facets[[0, 1, 2, 3, 0]][:, on_face]
    figure = go.Figure()
    for name, points, colour in (
        ("undeformed", mesh.p, PALE),
        ("deformed", mesh.p + MAGNIFICATION * moving.displacement, FEA),
    ):
        # Outlines of the facets as one line, broken by NaN.
        x, y, _ = np.pad(1e3 * points[:, around], ((0, 0), (0, 1), (0, 0)), constant_values=np.nan)
        x, y = x.T.ravel(), y.T.ravel()
        figure.add_scatter(x=x, y=y, name=name, mode="lines", line={"color": colour, "width": 1})
    figure.update_yaxes(scaleanchor="x", scaleratio=1)
    figure.update_xaxes(range=[-10, 1e3 * load_geometry().length + 20])
    return _dressed(figure, "x [mm]", "y [mm]")


def attempts_chart(result: Reproduction) -> Figure:
    """Elongation after an hour by every attempt, beside what was measured."""
    from plotly.subplots import make_subplots

    figure = make_subplots(
        rows=1, cols=2, subplot_titles=("stationary [µm]", "moving [µm]"), shared_yaxes=True
    )
    for column, case in enumerate(("stationary", "moving"), start=1):
        attempts = [a for a in result.attempts if a.case == case][::-1]
        figure.add_bar(
            x=[a.elongation for a in attempts], y=[a.name for a in attempts], orientation="h",
            text=[f"{a.elongation:.1f}" for a in attempts], marker_color=FEA, showlegend=False,
            textposition="outside", cliponaxis=False, row=1, col=column,
        )  # fmt: skip
        figure.update_xaxes(range=[0, 1.15 * max(a.elongation for a in attempts)], row=1, col=column)
        measured = load_paper()[case]["elongation_measured"].value
        figure.add_vline(x=measured, line={"color": PAPER, "dash": "dash"}, row=1, col=column)
        figure.add_scatter(
            x=[None], y=[None], mode="lines", name="measured", line={"color": PAPER, "dash": "dash"},
            showlegend=column == 1, row=1, col=column,
        )  # fmt: skip
    return _dressed(figure, None, None)


def _printed(figure: Figure, x: list[float], *quantities: str) -> Figure:
    """Mark what the paper prints for the moving case."""
    paper = load_paper()["moving"]
    for kind, symbol in (("measured", "x"), ("predicted", "cross")):
        figure.add_scatter(
            x=x, y=[paper[f"{quantity}_{kind}"].value for quantity in quantities],
            name=f"paper, moving, {kind}", mode="markers", cliponaxis=False,
            marker={"color": PAPER, "symbol": symbol, "size": 10},
        )  # fmt: skip
    return figure


def _temperatures(result: CaseResult) -> Figure:
    lines = [
        Line(f"{name}, above the {place}", history.temperature[where] - ZERO_CELSIUS)
        for name, history in (("3-D FEA", result.fea), ("1-D link", result.link))
        for where, place in (("base", "shaft"), ("tip", "diode"))
    ]
    return time_plot(result.fea.time, lines, "temperature [°C]", height=HEIGHT)


def _elongations(result: CaseResult) -> Figure:
    lines = [
        Line("3-D FEA", result.fea.elongation * 1e6),
        Line("1-D link", result.link.elongation * 1e6),
        Line("corrected Eq. (4)", result.corrected * 1e6),
        # As printed it begins beyond all bounds.
        Line("Eq. (4) as printed", np.minimum(result.printed * 1e6, 1.3 * result.corrected.max() * 1e6)),
    ]
    return time_plot(result.fea.time, lines, "elongation [µm]", height=HEIGHT)


def _bands(count: int) -> list[tuple[float, str]]:
    """A colour scale of equal steps, as a fringe plot has."""
    from plotly.colors import sample_colorscale

    colours = sample_colorscale("Turbo", np.linspace(0.05, 0.95, count).tolist())
    return [(edge / count, colour) for i, colour in enumerate(colours) for edge in (i, i + 1)]


def _dressed(figure: Figure, x_title: str | None, y_title: str | None) -> Figure:
    styled(figure, HEIGHT, 500).update_layout(margin_t=60)
    return figure.update_xaxes(title_text=x_title).update_yaxes(title_text=y_title)

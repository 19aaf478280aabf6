"""The page of a design: what the plant is like, and what the controller's reduced model keeps of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.design.plant import INPUTS, OUTPUTS, USUAL_SPEED, LinearPlant
from warmlink.controllers.design.reduction import Balanced, ReducedPlant, balanced
from warmlink.orchestration.report.figures import COLOURS, DASHES, styled
from warmlink.orchestration.report.page import Section, Table, versions, write_page

if TYPE_CHECKING:
    import control

SPEEDS = (0.0, USUAL_SPEED)
"""rad/s: standing still, and the paper's moving case."""

FREQUENCIES = np.logspace(-6, 0, 121)
"""rad/s: periods from two months to six seconds."""

UNITS = {name: "K" if name == "ambient_temperature" else "W" for name in INPUTS}


def write_report(plant: LinearPlant, reduced: ReducedPlant, title: str, lead: str, path: Path) -> None:
    """Write `report.html`.

    Parameters
    ----------
    plant, reduced : what was designed for, and what the controller goes by
    title, lead : the page's heading, and the answer
    path : file to write
    """
    error = reduced.error
    form = balanced(plant)
    sections = [
        Section(
            "Poles",
            "Time constants: how long it takes a pattern of temperatures to fall to 37 %.",
            table=_poles(plant, reduced),
        ),
        *(_bode(plant, reduced, speed) for speed in SPEEDS),
        Section(
            "What the reduction leaves out",
            f"{reduced.order} of {form.hankel.size} modes are kept. The response to a step of an ordinary "
            f"input is wrong by at most {1e6 * error.elongation_step:.2g} µm and "
            f"{error.temperature_step:.2g} K. The Hankel singular values say how much each mode passes from "
            "inputs to outputs.",
            figure=_hankel(form, reduced.order),
        ),
        Section("Software", table=versions()),
    ]
    write_page(path, title, lead, sections)


def _poles(plant: LinearPlant, reduced: ReducedPlant) -> Table:
    columns = [
        time_constants(model.state_space(speed))[: reduced.order]
        for speed in SPEEDS
        for model in (plant, reduced)
    ]
    headings = [f"{_motion(speed)}, {kind} [min]" for speed in SPEEDS for kind in ("full", "reduced")]
    rows = [
        [str(i), *(f"{each / 60:.3g}" for each in row)] for i, row in enumerate(zip(*columns, strict=True), 1)
    ]
    return Table(("pattern", *headings), rows)


def time_constants(model: control.StateSpace) -> NDArray[np.float64]:
    """Time constants in s, longest first, of a system that decays without swinging."""
    longest_first: NDArray[np.float64] = np.sort(-1 / np.real(model.poles()))[::-1]
    return longest_first


def _motion(speed: float) -> str:
    return f"{speed:g} rad/s" if speed else "still"


def _bode(plant: LinearPlant, reduced: ReducedPlant, speed: float) -> Section:
    """Magnitude and phase from every input to the elongation: the plant as lines, the reduced one as dots."""
    from plotly.subplots import make_subplots

    figure = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.06, row_heights=[0.6, 0.4])
    for model, mode, every in ((plant, "lines", 1), (reduced, "markers", 6)):
        magnitude, phase = _response(model.state_space(speed))
        for i, name in enumerate(INPUTS):
            look: dict[str, Any] = {
                "x": FREQUENCIES[::every],
                "mode": mode,
                "legendgroup": name,
                "line": {"color": COLOURS[i], "dash": DASHES[i % len(DASHES)]},
                "marker": {"color": COLOURS[i], "symbol": i, "size": 7},
            }
            title = f"{name} [{UNITS[name]}]" if mode == "lines" else f"{name}, reduced"
            figure.add_scatter(y=1e6 * magnitude[i][::every], name=title, row=1, col=1, **look)
            figure.add_scatter(y=phase[i][::every], showlegend=False, row=2, col=1, **look)
    figure.update_xaxes(type="log", exponentformat="power", dtick=1)
    figure.update_xaxes(title="frequency [rad/s]", row=2, col=1)
    figure.update_yaxes(title="elongation [µm/W, µm/K]", type="log", exponentformat="power", row=1, col=1)
    figure.update_yaxes(title="phase [degrees]", row=2, col=1)
    return Section(
        f"Bode plot, {_motion(speed)}", "From each input to the elongation.", figure=styled(figure, 560, 550)
    )


def _response(model: control.StateSpace) -> tuple[Any, Any]:
    """Magnitude and phase in degrees of the elongation, shape (inputs, frequencies)."""
    found = model.frequency_response(FREQUENCIES, squeeze=False)
    row = OUTPUTS.index("elongation")
    return found.magnitude[row], np.degrees(np.unwrap(found.phase[row], axis=-1))


def _hankel(form: Balanced, order: int) -> Any:
    import plotly.graph_objects as go

    shown = form.hankel[: 3 * order]
    colours = [COLOURS[0] if i < order else "#c3c9d4" for i in range(shown.size)]
    figure = go.Figure(go.Bar(x=list(range(1, shown.size + 1)), y=shown, marker_color=colours))
    figure.update_xaxes(title="mode (blue: kept)", dtick=1)
    figure.update_yaxes(title="Hankel singular value [1]", type="log", exponentformat="power")
    return styled(figure, 320)

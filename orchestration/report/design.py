"""The page of a design: what the plant is like, and what the controller's reduced model keeps of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.design.gains import expected
from warmlink.controllers.design.plant import INPUTS, OUTPUTS, USUAL_SPEED, LinearPlant
from warmlink.controllers.design.reduction import ReducedPlant, balanced
from warmlink.controllers.design.steady import steady, worth
from warmlink.controllers.interface import SENSED
from warmlink.controllers.start_values import Values
from warmlink.orchestration.report.figures import COLOURS, DASHES, chart, styled
from warmlink.orchestration.report.page import PageTable, Section, write_page

if TYPE_CHECKING:
    import control

SPEEDS = {"still": 0.0, f"{USUAL_SPEED:g} rad/s": USUAL_SPEED}
"""rad/s: standing still, and the paper's moving case."""

FREQUENCIES = np.logspace(-6, 0, 121)
"""rad/s: periods from two months to six seconds."""


def write_report(
    plant: LinearPlant, reduced: ReducedPlant, values: Values, title: str, lead: str, path: Path
) -> None:
    """Write the page of a plant that was designed for, and of what the controller goes by: its `values`."""
    order, error, hankel = reduced.order, reduced.error, balanced(plant).hankel
    columns, bode = [], []
    for motion, speed in SPEEDS.items():
        full, kept = plant.state_space(speed), reduced.state_space(speed)
        columns += [(f"{motion}, full [min]", full), (f"{motion}, reduced [min]", kept)]
        text = "From each input to the elongation: lines for the plant, dots for the reduced model."
        bode.append(Section(f"Bode plot, {motion}", text, figure=_bode(full, kept)))
    constants = np.column_stack([time_constants(model)[:order] for _, model in columns]) / 60
    rows = [[str(i), *(f"{each:.3g}" for each in row)] for i, row in enumerate(constants, 1)]
    shown = hankel[: 3 * order]
    colours = [COLOURS[0] if i < order else "#c3c9d4" for i in range(shown.size)]
    bars = {"type": "bar", "x": list(range(1, shown.size + 1)), "y": shown, "marker": {"color": colours}}
    sections = [
        *_filter(plant, reduced, values),
        Section(
            "Time constants of the plant",
            "How long it takes a pattern of temperatures to fall to 37 %.",
            PageTable(("pattern", *(heading for heading, _ in columns)), rows),
        ),
        *bode,
        Section(
            "What the reduction leaves out",
            f"{order} of {hankel.size} modes are kept. The response to a step of an ordinary "
            f"input is wrong by at most {1e6 * error.elongation_step:.2g} µm and "
            f"{error.temperature_step:.2g} K. The Hankel singular values say how much each mode passes from "
            "inputs to outputs.",
            figure=chart(
                bars,
                x={"title": "mode (blue: kept)", "dtick": 1},
                y={"title": "Hankel singular value [1]", "type": "log", "exponentformat": "power"},
                height=320,
            ),
        ),
    ]
    write_page(path, title, lead, sections)


def _filter(plant: LinearPlant, reduced: ReducedPlant, values: Values) -> list[Section]:
    """The filter at the usual speed in the long run, and what each set of thermometers is worth."""
    stds = np.ravel(np.asarray(values["sensor_std"], dtype=float))
    noise = {name: float(std) for name, std in zip(SENSED, stds, strict=True) if std > 0}
    period, unknown = float(np.ravel(values["sample_time"])[0]), expected(plant)
    found, sets = steady(reduced, unknown, noise, period), worth(reduced, unknown, noise, period)
    gains = [
        (name, f"{noise[name]:g}", f"{1e6 * gain:.3g}") for name, gain in zip(noise, found.gains, strict=True)
    ]
    poles = [(str(i), f"{time / 60:.3g}") for i, time in enumerate(found.time_constants, 1)]
    errors = [
        (", ".join(some) or "none, the duty alone", f"{1e6 * error:.3g}") for some, error in sets.items()
    ]
    when = f"In the long run at {USUAL_SPEED:g} rad/s, with the unknown heat that the design expects"
    return [
        Section(
            "Expected error, and which thermometers are worth their cable",
            f"{when}: {1e6 * found.error:.3g} µm (1 sigma), the reduction's error included. With fewer:",
            PageTable(("thermometers", "expected error [µm]"), errors),
        ),
        Section(
            "Gains of the filter",
            "How fast the correction moves for each kelvin by which a reading surprises the filter.",
            PageTable(("thermometer", "noise [K]", "gain [µm/s/K]"), gains),
        ),
        Section(
            "Poles of the filter",
            "As time constants: how long an error of its estimate takes to fall to 37 %.",
            PageTable(("pole", "time constant [min]"), poles),
        ),
    ]


def time_constants(model: control.StateSpace) -> NDArray[np.float64]:
    """Time constants in s, longest first, of a system that decays without swinging."""
    longest_first: NDArray[np.float64] = np.sort(-1 / np.real(model.poles()))[::-1]
    return longest_first


def _bode(plant: control.StateSpace, reduced: control.StateSpace) -> Any:
    """Magnitude and phase from every input to the elongation: the plant as lines, the reduced one as dots."""
    from plotly.subplots import make_subplots

    figure = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.06, row_heights=[0.6, 0.4])
    row = OUTPUTS.index("elongation")
    for model, mode, every in ((plant, "lines", 1), (reduced, "markers", 6)):
        found = model.frequency_response(FREQUENCIES, squeeze=False)
        magnitude, phase = found.magnitude[row], np.degrees(np.unwrap(found.phase[row], axis=-1))
        for i, name in enumerate(INPUTS):
            look: dict[str, Any] = {
                "x": FREQUENCIES[::every],
                "mode": mode,
                "legendgroup": name,
                "line": {"color": COLOURS[i], "dash": DASHES[i % len(DASHES)]},
                "marker": {"color": COLOURS[i], "symbol": i, "size": 7},
            }
            unit = "K" if name == "ambient_temperature" else "W"
            named = {"name": f"{name} [{unit}]", "showlegend": mode == "lines"}
            figure.add_scatter(y=1e6 * magnitude[i][::every], row=1, col=1, **named, **look)
            figure.add_scatter(y=phase[i][::every], showlegend=False, row=2, col=1, **look)
    figure.update_xaxes(type="log", exponentformat="power", dtick=1)
    figure.update_xaxes(title="frequency [rad/s]", row=2, col=1)
    figure.update_yaxes(title="elongation [µm/W, µm/K]", type="log", exponentformat="power", row=1, col=1)
    figure.update_yaxes(title="phase [degrees]", row=2, col=1)
    return styled(figure, 560)

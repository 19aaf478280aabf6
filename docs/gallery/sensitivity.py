"""Which parameter matters.

Each parameter of motor and link 20 % larger, one at a time: by how much does the growth after two hours
change?
"""

import plotly.graph_objects as go

import warmlink as wl
from warmlink.orchestration.catalogue import components
from warmlink.orchestration.report.figures import COLOURS, styled
from warmlink.orchestration.scenarios.mismatch import EXPANSION, THERMAL_PARAMETERS

kinds = {"motor": components()["MotorHeatSource"], "link": components()["ThermalLink"]}
starts = {f"{part}.{each.name}": each.start for part, kind in kinds.items() for each in kind.scalars()}


def growth(**given: float) -> float:
    """Elongation in µm after two hours."""
    return 1e6 * wl.run("windshield_wiper", "none", parameters=given, step="20 s").uncompensated_error[-1]


nominal = growth()
changes = {name: growth(**{name: 1.2 * starts[name]}) - nominal for name in (*THERMAL_PARAMETERS, EXPANSION)}
names = sorted(changes, key=lambda name: abs(changes[name]))
figure = go.Figure(
    go.Bar(x=[changes[n] for n in names], y=names, orientation="h", marker={"color": COLOURS[0]})
)
figure.update_xaxes(title="change of the growth [µm]")
figure.update_yaxes(automargin=True)
figure = styled(figure, 420, 520)

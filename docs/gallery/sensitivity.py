"""Which parameter matters.

Each parameter of motor and link 20 % larger, one at a time: by how much does the growth after two hours
change?
"""

from pathlib import Path

import plotly.graph_objects as go

import warmlink as wl

PARAMETERS = {
    "motor": ("winding_heat_capacity", "winding_conductance", "shaft_heat_capacity", "housing_conductance"),
    "link": ("conductivity", "specific_heat", "convection_still", "convection_per_speed"),
}
NAMES = [f"{part}.{each}" for part, parameters in PARAMETERS.items() for each in parameters]


def growth(*mismatches: str | Path) -> float:
    """Elongation in µm after two hours."""
    run = wl.run("windshield_wiper", "none", mismatches=mismatches, step="20 s")
    return 1e6 * run.uncompensated_error[-1]


nominal, changes = growth(), {}
for name in ("motor.joint_conductance", *NAMES, "link.expansion_coefficient"):
    larger = Path(f"{name}.toml")
    larger.write_text(f'[scale]\n"{name}" = 1.2\n')
    changes[name] = growth(larger) - nominal
names = sorted(changes, key=lambda name: abs(changes[name]))
figure = go.Figure(go.Bar(x=[changes[name] for name in names], y=names, orientation="h"))
figure.update_xaxes(title="change of the growth [µm]")
figure.update_yaxes(automargin=True)
figure.update_layout(height=420)

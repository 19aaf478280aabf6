"""What the link is made of.

The same cell and the same work: aluminium conducts the heat to its tip and grows most, invar hardly
grows.
"""

from pathlib import Path

import warmlink as wl
from warmlink.orchestration.report.figures import time_plot

lines = {}
for material in ("aluminium_6061", "steel", "cast_iron", "invar"):
    path = Path(f"{material}.toml")
    path.write_text(f'duty = "windshield_wiper"\ncontroller = "none"\n[materials]\nlink = "{material}"\n')
    run = wl.run(path, step="5 s")
    lines[material] = 1e6 * run.uncompensated_error
figure = time_plot(run.time, lines, "elongation [µm]")

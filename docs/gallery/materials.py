"""What the link is made of.

The same cell and the same work: aluminium conducts the heat to its tip and grows most, invar hardly
grows.
"""

from pathlib import Path

import pandas

import warmlink as wl

materials = ("aluminium_6061", "steel", "cast_iron", "invar")
growths = {}
for material in materials:
    path = Path(f"{material}.toml")
    path.write_text(f'duty = "windshield_wiper"\ncontroller = "none"\n[materials]\nlink = "{material}"\n')
    run = wl.run(path, step="5 s")
    growths[f"{material} [m]"] = run.uncompensated_error
figure = wl.plot(pandas.DataFrame({"time [s]": run.time, **growths}), *materials)

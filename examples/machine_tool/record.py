"""Runs the real machine for a shift, and writes what thermometers with 0.05 K of noise record, `run.csv`."""

from pathlib import Path

import numpy as np

import warmlink as wl

Path("real.toml").write_text(Path("machine.toml").read_text("utf-8").replace("machine.ssp", "real.ssp"))
shift = wl.run("real.toml", "none", step="1 s").to_frame()

READ = {
    "spindle [1]": "spindle.temperature [1]",
    "column base [degC]": "column.base_temperature [K]",
    "column tip [degC]": "column.tip_temperature [K]",
    "table base [degC]": "table.base_temperature [K]",
}
noise = np.random.default_rng(1)
run = shift[["time [s]"]].assign(**{"speed [1]": shift["duty.speed [rad/s]"], "room [degC]": 22.0})
for header, variable in READ.items():
    zero = 273.15 if "degC" in header else 0.0
    run[header] = shift[variable] - zero + noise.normal(0.0, 0.05, len(shift))
run[::60].to_csv("run.csv", index=False)

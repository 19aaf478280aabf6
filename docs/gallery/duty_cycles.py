"""Duty cycles.

How fast the joint turns, in rad/s, in three of the shipped cycles. A duty cycle of your own is a table in a
TOML file, or a recorded CSV.
"""

import pandas

import warmlink as wl

names = ("shift_with_breaks", "random_jobs", "stop_and_go")
runs = {name: wl.run(name, "none", stop="4 h", step="30 s").to_frame() for name in names}
speeds = {f"{name} [rad/s]": run["duty.speed [rad/s]"] for name, run in runs.items()}
figure = wl.plot(pandas.DataFrame({"time [s]": runs["stop_and_go"]["time [s]"], **speeds}), *names)

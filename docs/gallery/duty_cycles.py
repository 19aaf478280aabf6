"""Duty cycles.

What the joint is asked to do, in three of the shipped cycles. A duty cycle of your own is a table in a
TOML file, or a recorded CSV.
"""

import numpy as np

from warmlink.orchestration.report.figures import Line, time_plot
from warmlink.orchestration.scenarios.duties import duty_files

names = ("shift_with_breaks", "random_jobs", "stop_and_go")
tables = {name: duty_files.load(name).table(30.0, 4 * 3600.0) for name in names}
times = 30.0 * np.arange(len(tables[names[0]]))
figure = time_plot(times, [Line(name, table[:, 0]) for name, table in tables.items()], "speed [rad/s]")

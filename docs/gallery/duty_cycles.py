"""Duty cycles.

What the joint is asked to do, in three of the shipped cycles. A duty cycle of your own is a table in a
TOML file, or a recorded CSV.
"""

import numpy as np

from warmlink.orchestration.report.figures import time_plot
from warmlink.orchestration.scenarios.duties import duty_files
from warmlink.orchestration.scenarios.duties.duty import demands_at

names = ("shift_with_breaks", "random_jobs", "stop_and_go")
times = 30.0 * np.arange(480)
speeds = {name: demands_at(duty_files.load(name).unrolled(), times)["speed"] for name in names}
figure = time_plot(times, speeds, "speed [rad/s]")

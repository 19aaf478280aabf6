"""A thermometer breaks.

After twenty minutes the base thermometer jumps by 6 K. The observer notices, leaves it out, and goes on
with the other one and the duty; the regression follows it.
"""

import warmlink as wl
from warmlink.orchestration.report.figures import time_plot

broken = {"sensors.fault_kind[3]": 2, "sensors.fault_time[3]": "20 min", "sensors.fault_size[3]": "6 K"}
runs = {
    law: wl.run("windshield_wiper", law, parameters=broken, stop="1 h") for law in ("regression", "observer")
}
lines = {law: 1e6 * run.error for law, run in runs.items()}
figure = time_plot(runs["observer"].time, lines, "error of the tool point [µm]", tolerance=5)

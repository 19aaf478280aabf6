"""Three laws under the same conditions.

All thermal parameters are 20 % larger than the laws assume, and the thermometers are noisy. What no
thermometer tells (`lag` uses none) stays as an error.
"""

import warmlink as wl
from warmlink.orchestration.report.figures import time_plot

runs = {
    law: wl.run("stop_and_go", law, mismatches=["thermal_high", "noisy_sensors"], step="2 s")
    for law in ("lag", "regression", "observer")
}
lines = {law: 1e6 * run.error for law, run in runs.items()}
figure = time_plot(runs["lag"].time, lines, "error of the tool point [µm]", tolerance=5)

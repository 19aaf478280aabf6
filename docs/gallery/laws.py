"""Three laws under the same conditions.

All thermal parameters are 20 % larger than the laws assume, and the thermometers are noisy. What no
thermometer tells (`lag` uses none) stays as an error.
"""

import pandas

import warmlink as wl

runs = {
    law: wl.run("stop_and_go", law, mismatches=["thermal_high", "noisy_sensors"], step="2 s")
    for law in ("lag", "regression", "observer")
}
errors = {f"{law} [m]": run.error for law, run in runs.items()}
figure = wl.plot(pandas.DataFrame({"time [s]": runs["lag"].time, **errors}), *runs)

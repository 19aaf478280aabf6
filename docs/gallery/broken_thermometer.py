"""A thermometer breaks.

After twenty minutes the base thermometer jumps by 6 K. The observer notices, leaves it out, and goes on
with the other one and the duty; the regression follows it.
"""

import pandas

import warmlink as wl

broken = {"sensors.fault_kind[3]": 2, "sensors.fault_time[3]": "20 min", "sensors.fault_size[3]": "6 K"}
runs = {
    law: wl.run("windshield_wiper", law, parameters=broken, stop="1 h") for law in ("regression", "observer")
}
errors = {f"{law} [m]": run.error for law, run in runs.items()}
figure = wl.plot(pandas.DataFrame({"time [s]": runs["observer"].time, **errors}), *runs)

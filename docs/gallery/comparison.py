"""Every law in several duty cycles.

Largest errors in µm, with every thermal parameter 20 % off and with noisy thermometers: blue is below
the tolerance of 5 µm, orange above it. `warmlink compare` draws this for all of them.
"""

import warmlink as wl

laws = ["lag", "regression", "observer"]
duties = ["stop_and_go", "windshield_wiper", "heavy_payload"]
figure = wl.plot(wl.compare(laws, duties, ["thermal_high", "noisy_sensors"], options=wl.RunOptions(jobs=1)))

"""Every law in several duty cycles.

Largest errors in µm, with every thermal parameter 20 % off and with noisy thermometers: blue is below
the tolerance of 5 µm, orange above it. `warmlink compare` draws this for all of them.
"""

import warmlink as wl
from warmlink.orchestration.report.figures import heat_map

laws = ["none", "lag", "regression", "observer"]
duties = ["stop_and_go", "windshield_wiper", "heavy_payload"]
compared = wl.compare(laws, duties, ["thermal_high", "noisy_sensors"], means=wl.Means(jobs=1))
table = compared.to_frame().pivot_table("max_abs_um", "duty_cycle", "controller", "max")[laws]
texts = [[f"{value:.1f}" for value in line] for line in table.to_numpy()]
figure = heat_map(laws, list(table.index), table.to_numpy(), texts, 5.0, "µm")

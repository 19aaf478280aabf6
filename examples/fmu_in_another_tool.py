"""The same FMU in FMPy and in our master.

FMPy runs an FMU alone; our master runs a system with one component. Both step the same binary, so that the
growth of the link agrees to the last digits.
"""

import fmpy
import numpy as np

import warmlink as wl

fmu = wl.fmu_files("ThermalLink")["ThermalLink"]
heating = {"heat_flow": 2.0, "speed": 1.0}

in_fmpy = fmpy.simulate_fmu(
    str(fmu), stop_time=1800, step_size=10, output_interval=10, start_values=heating, output=["elongation"]
)
alone = wl.assemble("Link alone", {"link": fmu}, values={"link": heating})
ours = wl.simulate(alone, stop="30 min", step="10 s").to_frame()
print(f"growth after 30 min: {1e6 * in_fmpy['elongation'][-1]:.3f} µm")

np.testing.assert_allclose(in_fmpy["elongation"], ours["link.elongation [m]"], rtol=1e-12, atol=1e-15)
assert 20e-6 < in_fmpy["elongation"][-1] < 200e-6

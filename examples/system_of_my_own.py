"""A component of your own becomes an FMU, and a part of a system.

A thermostat, declared in a few lines, switches the heater of a rod. The thermostat is compiled to a native
FMU; the heater and the rod are shipped. The system is written as an SSP, which other tools read as well.
"""

from pathlib import Path
from tempfile import mkdtemp

import warmlink as wl
from warmlink import Component, Input, Output, Parameter, State, where

THERMOSTAT = Component(
    name="Thermostat",
    description="Switches a heater on below a temperature and off above another",
    inputs=(Input("temperature", "K", "measured temperature", start=295.15, nominal=300),),
    parameters=(
        Parameter("low", "K", 307.15, "temperature below which the heater is on"),
        Parameter("high", "K", 309.15, "temperature above which the heater is off"),
        Parameter("sample_time", "s", 1.0, "time between two decisions", minimum=0.001),
    ),
    states=(State("on", "1", start=1.0),),
    outputs=(Output("on", "1", "1 while the heater is on"),),
    update=lambda x, u, p, time, step: {
        "on": where(u.temperature < p.low, 1.0, where(u.temperature > p.high, 0.0, x.on))
    },
    observe=lambda x, u, p, time: {"on": x.on},
)

fmus = wl.fmu_files([THERMOSTAT, "Heater", "ThermalLink"])
system = wl.assemble(
    "Thermostat rod",
    {"thermostat": fmus["Thermostat"], "heater": fmus["Heater"], "link": fmus["ThermalLink"]},
    [
        ("thermostat.on", "heater.on"),
        ("heater.heat_flow", "link.heat_flow"),
        ("link.base_temperature", "heater.link_base_temperature"),
        ("link.base_temperature", "thermostat.temperature"),
    ],
)
folder = Path(mkdtemp())
wl.write_ssp(system, f"{folder}/rod.ssp")
result = wl.simulate(folder / "rod.ssp", stop="40 min", step="1 s")
frame = result.to_frame()
figure = wl.plot(frame, "link.base_temperature", "link.tip_temperature")

settled = frame["link.base_temperature [K]"][frame["time [s]"] > 1200]
assert 306.5 < settled.min() < settled.max() < 310.0

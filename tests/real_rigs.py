"""Experiments on strangers' rigs, as their owners would write them; their measurements stay where they are.

Each writes its experiment, and what an owner would put into a spreadsheet first, into a folder of the
caller's. A test that asks for one is skipped where the measurements are absent.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from tests.shared_data import given


@dataclass(frozen=True)
class Rig:
    """An experiment, what prepares its files, and the held-out errors that plain fits reach.

    `plain` is the least error of any plain fit by column, in K or um, as an issue of this project states it.
    """

    title: str
    text: str
    prepare: Callable[[Path], None]
    plain: dict[str, float]

    def write(self, folder: Path) -> Path:
        """Write the experiment and its files; returns the path of the experiment."""
        self.prepare(folder)
        path = folder / "experiment.toml"
        path.write_text(f'title = "{self.title}"\n{self.text}', encoding="utf-8")
        return path


def _drone(*runs: str) -> Callable[[Path], None]:
    def prepare(folder: Path) -> None:
        for run in runs:
            source = given(f"real/drone_motor/run{run}.csv")
            (folder / source.name).write_bytes(source.read_bytes())

    return prepare


_DRONE = """
system = "BenchMotor"
initial = "measured"
[[run]]
data = "run{fitted}.csv"
[[run]]
data = "run{held_out}.csv"
heldout = true
[channels]
"current [A]" = "motor.current"
"ambient_temperature [degC]" = "motor.ambient_temperature"
"winding [degC]" = "motor.winding_temperature"
"stator [degC]" = "motor.shaft_temperature"
[known]
"motor.coulomb_friction" = "0 N*m"
"motor.viscous_friction" = "0 N*m*s/rad"
"motor.iron_loss_coefficient" = "0 W*s**2/rad**2"
"motor.joint_conductance" = "0 W/K"
[calibrate]
"motor.winding_resistance" = {{ min = "0.05 ohm", max = "2 ohm", start = "0.3 ohm" }}
"motor.winding_heat_capacity" = {{ min = "20 J/K", max = "400 J/K", start = "80 J/K" }}
"motor.shaft_heat_capacity" = {{ min = "50 J/K", max = "1500 J/K", start = "300 J/K" }}
"motor.winding_conductance" = {{ min = "0.2 W/K", max = "20 W/K", start = "2 W/K" }}
"motor.housing_conductance" = {{ min = "0.01 W/K", max = "5 W/K", start = "0.5 W/K" }}
"""

_PLACES = (12, 35, 70, 150, 310, 610)
"""mm of the sensors from the driven end of the copper bar."""

_LONG = 650


def _bars(folder: Path) -> None:
    names = ["reference", "source", *(f"S{i}" for i in range(1, 7))]
    for run in ("Cu_1mHz", "Cu_2mHz"):
        table = pd.read_csv(given(f"real/angstrom_bars/{run}.csv"), header=None)
        table = table[table[1] != 0]  # the logger begins with zeros
        table.columns = ["time [s]", *(f"{name} [degC]" for name in names)]
        table.to_csv(folder / f"{run}.csv", index=False)


_BARS = f"""
system = "BenchRod"
initial = "measured"
[[run]]
data = "Cu_1mHz.csv"
[[run]]
data = "Cu_2mHz.csv"
heldout = true
[channels]
"source [degC]" = "link.tip_sink_temperature"
{"".join(f'"S{i} [degC]" = "link.sensor_temperature[{i}]"' + chr(10) for i in range(1, 7))}
[known]
"heater.on" = "0"
"link.length" = "{_LONG} mm"
"link.base_position" = "0 mm"
"link.tip_position" = "{_LONG} mm"
"link.width" = "25 mm"
"link.thickness" = "6 mm"
"link.conductivity" = "390 W/(m*K)"
"link.density" = "8960 kg/m**3"
{"".join(f'"link.sensor_position[{i}]" = "{_LONG - at} mm"' + chr(10) for i, at in enumerate(_PLACES, 1))}
[calibrate]
"link.specific_heat" = {{ min = "250 J/(kg*K)", max = "800 J/(kg*K)", start = "385 J/(kg*K)" }}
"link.convection_still" = {{ min = "1 W/(m**2*K)", max = "60 W/(m**2*K)", start = "8 W/(m**2*K)" }}
"link.tip_conductance" = {{ min = "0.1 W/K", max = "200 W/K", start = "20 W/K" }}
"link.ambient_temperature" = {{ min = "15 degC", max = "30 degC", start = "22 degC" }}
"""


def _frame(folder: Path) -> None:
    for name, file in (("first", "run_2021-06-13_05h"), ("second", "run_2021-06-13_20h")):
        table = pd.read_csv(given(f"real/voron_frame/{file}.csv"))
        table["growth [um]"] = -table.pop("z [um]")
        table.to_csv(folder / f"{name}.csv", index=False)


_FRAME = """
system = "BenchRod"
initial = "measured"
[[run]]
data = "first.csv"
[[run]]
data = "second.csv"
heldout = true
[channels]
"chamber [degC]" = "link.ambient_temperature"
"bed [degC]" = "link.tip_sink_temperature"
"frame [degC]" = "link.sensor_temperature[1]"
"growth [um]" = "link.elongation"
[known]
"heater.on" = "0"
"link.length" = "530 mm"
"link.base_position" = "0 mm"
"link.tip_position" = "530 mm"
"link.width" = "20 mm"
"link.thickness" = "20 mm"
"link.sensor_position[1]" = "265 mm"
[calibrate]
"link.expansion_coefficient" = { min = "10e-6 1/K", max = "80e-6 1/K", start = "23.6e-6 1/K" }
"link.convection_still" = { min = "1 W/(m**2*K)", max = "30 W/(m**2*K)", start = "8 W/(m**2*K)" }
"link.tip_conductance" = { min = "0 W/K", max = "1 W/K", start = "0.05 W/K" }
"link.specific_heat" = { min = "400 J/(kg*K)", max = "4000 J/(kg*K)", start = "900 J/(kg*K)" }
"""


def _house(folder: Path) -> None:
    table = pd.read_csv(given("real/house/demo_data.csv"), index_col=0, parse_dates=True)
    hours = (table.index - table.index[0]).total_seconds() / 3600
    shown = pd.DataFrame(
        {
            "time [h]": hours,
            "heating [W]": 100 * table["Ph"].to_numpy(),  # of about 100 W is the owner's unit
            "outside [degC]": table["Ta"].to_numpy(),
            "room [degC]": table["Ti"].to_numpy(),
            "radiators [degC]": table["Th"].to_numpy(),
        }
    )
    first = shown["time [h]"] < 13 * 24
    shown[first].to_csv(folder / "first.csv", index=False)
    later = shown[~first].copy()
    later["time [h]"] -= later["time [h]"].iloc[0]
    later.to_csv(folder / "later.csv", index=False)


_HOUSE = """
system = "BenchMotor"
initial = "measured"
[[run]]
data = "first.csv"
[[run]]
data = "later.csv"
heldout = true
[channels]
"heating [W]" = "heating.power"
"outside [degC]" = "motor.ambient_temperature"
"room [degC]" = "motor.shaft_temperature"
"radiators [degC]" = "motor.winding_temperature"
[term.heating]
heat = "share * power"
into = "winding"
inputs = { power = "0 W" }
parameters = { share = 1 }
[known]
"motor.speed" = "0 rad/s"
"motor.torque" = "0 N*m"
"motor.coulomb_friction" = "0 N*m"
"motor.viscous_friction" = "0 N*m*s/rad"
"motor.iron_loss_coefficient" = "0 W*s**2/rad**2"
"motor.joint_conductance" = "0 W/K"
"motor.winding_temperature_coefficient" = "0 1/K"
[calibrate]
"heating.share" = { min = 0.01, max = 10, start = 1 }
"motor.winding_heat_capacity" = { min = "1e4 J/K", max = "1e7 J/K", start = "2e5 J/K" }
"motor.shaft_heat_capacity" = { min = "1e5 J/K", max = "1e9 J/K", start = "1e7 J/K" }
"motor.winding_conductance" = { min = "1 W/K", max = "1000 W/K", start = "60 W/K" }
"motor.housing_conductance" = { min = "5 W/K", max = "2000 W/K", start = "150 W/K" }
"""


def _pouch(folder: Path) -> None:
    source = given("real/pouch_cell/all.csv")
    table = pd.read_csv(source)
    table[table["time [s]"] < 650].to_csv(folder / "fit.csv", index=False)
    table.to_csv(folder / "all.csv", index=False)


_POUCH = """
system = "BenchMotor"
initial = "measured"
[[run]]
data = "fit.csv"
[[run]]
data = "all.csv"
heldout = true
[channels]
"room [degC]" = "motor.ambient_temperature"
"heater [degC]" = "motor.neighbour_temperature"
"spot [degC]" = "motor.shaft_temperature"
"face [degC]" = "motor.winding_temperature"
[known]
"motor.speed" = "0 rad/s"
"motor.torque" = "0 N*m"
"motor.joint_conductance" = "0 W/K"
[calibrate]
"motor.neighbour_conductance" = { min = "0.01 W/K", max = "2 W/K", start = "0.1 W/K" }
"motor.winding_heat_capacity" = { min = "20 J/K", max = "1000 J/K", start = "250 J/K" }
"motor.shaft_heat_capacity" = { min = "5 J/K", max = "500 J/K", start = "60 J/K" }
"motor.winding_conductance" = { min = "0.05 W/K", max = "20 W/K", start = "1 W/K" }
"motor.housing_conductance" = { min = "0.001 W/K", max = "2 W/K", start = "0.1 W/K" }
"""

RIGS = {
    "drone motor, 10D to 10C": Rig(
        "A drone's motor heats itself",
        _DRONE.format(fitted="10D", held_out="10C"),
        _drone("10D", "10C"),
        {"winding": 6.3, "stator": 1.8},
    ),
    "drone motor, 13 to 14": Rig(
        "A drone's motor heats itself",
        _DRONE.format(fitted="13", held_out="14"),
        _drone("13", "14"),
        {"winding": 14.9},
    ),
    "copper bar": Rig(
        "A copper bar, driven at 1 mHz, then at 2",
        _BARS,
        _bars,
        {f"S{i}": 0.44 for i in range(1, 7)},
    ),
    "printer's frame": Rig("The frame of a printer", _FRAME, _frame, {"growth": 10.6}),
    "house": Rig("A house in winter, hour by hour", _HOUSE, _house, {"room": 0.65}),
    "pouch cell": Rig("A pouch cell with a heater", _POUCH, _pouch, {"spot": 0.12, "face": 0.23}),
}
"""Every experiment by its name."""

"""Two machines that nobody here knows: a gantry of two axes, and a foreign spindle on a column."""

from __future__ import annotations

import shutil
from pathlib import Path

from benchmarks.own_systems import spindle
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.system.assemble import component, connected
from warmlink.orchestration.system.model import DefaultExperiment, System
from warmlink.orchestration.system.write import write_ssp

ROLES = Path(__file__).parent
GANTRY = {
    **{"x_motor": "MotorHeatSource", "x_link": "ThermalLink", "y_motor": "MotorHeatSource"},
    **{"y_link": "ThermalLink", "sensors": "TemperatureSensors", "brain": "LagCompensator"},
}
GANTRY_WIRES = (
    ("x_motor.heat_flow", "x_link.heat_flow"),
    ("x_link.base_temperature", "x_motor.link_base_temperature"),
    ("y_motor.heat_flow", "y_link.heat_flow"),
    ("y_link.base_temperature", "y_motor.link_base_temperature"),
    ("x_link.base_temperature", "sensors.temperature[3]"),
    ("y_link.tip_temperature", "sensors.temperature[5]"),
    ("sensors.reading[3]", "brain.base_temperature"),
    ("sensors.reading[5]", "brain.tip_temperature"),
)
COLUMN = {"column": "ThermalLink", "sensors": "TemperatureSensors", "compensator": "LagCompensator"}
COLUMN_WIRES = (
    ("spindle.heat", "column.heat_flow"),
    ("column.base_temperature", "spindle.column"),
    ("column.base_temperature", "sensors.temperature[3]"),
    ("column.tip_temperature", "sensors.temperature[5]"),
    ("sensors.reading[3]", "compensator.base_temperature"),
    ("sensors.reading[5]", "compensator.tip_temperature"),
)


def machine(name: str, folder: Path) -> Path:
    """The SSP of a machine in a folder, with the file of its roles beside it, whose path is given."""
    kinds, wires = (GANTRY, GANTRY_WIRES) if name == "gantry" else (COLUMN, COLUMN_WIRES)
    files = FmuStore("native").files(kinds.values())
    parts = {each: component(each, files[kind]) for each, kind in kinds.items()}
    if name == "spindle":
        parts["spindle"] = component("spindle", spindle(folder))
    system = System(name.title(), parts, connected(parts, wires), DefaultExperiment(0.0, 3600.0, 1.0))
    write_ssp(system, folder / f"{name}.ssp")
    return Path(shutil.copy(ROLES / f"{name}.toml", folder))

"""Writes `machine.ssp`, a machine tool as its maker thinks of it, and `real.ssp`, as it really is.

The spindle is a foreign FMU; column and table are ThermalLinks of cast iron. In the real machine cooling
lubricant carries heat from the spindle to the table, which the maker does not know.
"""

from pythonfmu.builder import FmuBuilder

import warmlink as wl

IRON = {"conductivity": 50.0, "density": 7200.0, "specific_heat": 500.0, "expansion_coefficient": 10.5e-6}
CASTING = {**IRON, "cross_section": 0.004, "perimeter": 0.3, "base_position": 0.05}
VALUES = {
    "column": {**CASTING, "length": 0.6, "tip_position": 0.55},
    "table": {**CASTING, "length": 0.5, "tip_position": 0.45},
}
WIRES = [
    ("duty.speed", "spindle.speed"),
    ("duty.ambient_temperature", "spindle.room"),
    ("duty.ambient_temperature", "column.ambient_temperature"),
    ("duty.ambient_temperature", "table.ambient_temperature"),
    ("spindle.heat", "column.heat_flow"),
    ("column.base_temperature", "spindle.column"),
    ("spindle.temperature", "compensator.shaft_temperature"),
    ("column.base_temperature", "compensator.base_temperature"),
    ("column.tip_temperature", "compensator.tip_temperature"),
]
LUBRICANT = [
    ("spindle.temperature", "lubricant.from_temperature"),
    ("table.base_temperature", "lubricant.to_temperature"),
    ("lubricant.total_to_heat_flow", "table.heat_flow"),
]

spindle = FmuBuilder.build_FMU("spindle.py", dest=".", needsExecutionTool="false")
kinds = {
    "duty": "DutyCycle",
    "column": "ThermalLink",
    "table": "ThermalLink",
    "lubricant": "HeatPath",
    "compensator": "RegressionCompensator",
}
files = wl.fmu_files(set(kinds.values()))
parts = {"spindle": spindle, **{name: files[kind] for name, kind in kinds.items()}}
real = wl.assemble("Machine", parts, WIRES + LUBRICANT, {**VALUES, "lubricant": {"conductance": 0.6}})
del parts["lubricant"]
machine = wl.assemble("Machine", parts, WIRES, VALUES)
for system, name in ((machine, "machine.ssp"), (real, "real.ssp")):
    wl.write_ssp(system, name)

"""Systems of a stranger's, and runs of them computed by the master algorithm from their FMUs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.assemble import component, connected
from warmlink.orchestration.system.model import DefaultExperiment, System, Value
from warmlink.orchestration.system.write import write_ssp

Values = Mapping[str, Mapping[str, Value]]

CHAIN = {
    "duty": "DutyCycle",
    "motor1": "MotorHeatSource",
    "link1": "ThermalLink",
    "motor2": "MotorHeatSource",
    "link2": "ThermalLink",
}
CHAIN_WIRES = (
    *(("duty.speed", f"{part}.speed") for part in ("motor1", "link1", "motor2", "link2")),
    ("duty.torque", "motor1.torque"),
    *(("duty.ambient_temperature", f"{part}.ambient_temperature") for part in list(CHAIN)[1:]),
    *((f"duty.pad_{name}", f"motor1.pad_{name}") for name in ("mode", "temperature", "power")),
    ("motor1.heat_flow", "link1.heat_flow"),
    ("link1.base_temperature", "motor1.link_base_temperature"),
    ("motor2.heat_flow", "link2.heat_flow"),
    ("link2.base_temperature", "motor2.link_base_temperature"),
)
CHANNELS = {
    "motor 1 [degC]": "motor1.shaft_temperature",
    "base 1 [degC]": "link1.base_temperature",
    "tip 1 [degC]": "link1.tip_temperature",
    "motor 2 [degC]": "motor2.shaft_temperature",
    "base 2 [degC]": "link2.base_temperature",
    "tip 2 [degC]": "link2.tip_temperature",
}
INPUTS = {
    "speed [rad/s]": "motor1.speed",
    "torque [N.m]": "motor1.torque",
    "room [degC]": "motor1.ambient_temperature",
}
CELL = {name: CHAIN[f"{name}1"] for name in ("motor", "link")} | {"duty": "DutyCycle"}
CELL_WIRES = tuple(
    (source.replace("1.", "."), target.replace("1.", "."))
    for source, target in CHAIN_WIRES
    if "2." not in source + target
)
CELL_INPUTS = {header: name.replace("1.", ".") for header, name in INPUTS.items()}
CELL_CHANNELS = {h.replace(" 1", ""): n.replace("1.", ".") for h, n in CHANNELS.items() if "1." in n}
INPUT_HEADERS = ("speed", "torque", "room")
SPINDLE = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

START = {
    Fmi2Causality.input: {"speed": 0.0, "room": 295.15, "column": 295.15, "cover": 0.0},
    Fmi2Causality.parameter: {"friction": 2.0, "capacity": 900.0, "loss": 0.4, "flange": 1.5},
    Fmi2Causality.output: {"temperature": 295.15, "heat": 0.0},
}


class Spindle(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for causality, values in START.items():
            for name, value in values.items():
                setattr(self, name, value)
                more = {"variability": Fmi2Variability.tunable} if "parameter" in str(causality) else {}
                self.register_variable(Real(name, causality=causality, **more))

    def do_step(self, time, step):
        for _ in range(4):
            self.heat = self.flange * (self.temperature - self.column)
            lost = self.loss * (self.temperature - self.room) + self.heat
            gained = self.friction * abs(self.speed) + self.cover - lost
            self.temperature += step / 4 * gained / self.capacity
        return True
"""
"""Source of an FMU that was not made by warmlink, without units: a machine tool's spindle, in SI."""

SEGMENTS = ((1200.0, 3.4, 2.5), (900.0, 0.0, 0.0), (1500.0, 1.0, 4.0), (900.0, 0.0, 0.0))
"""s, rad/s, N.m"""


def system(
    name: str, kinds: Mapping[str, str], wires: tuple[tuple[str, str], ...], values: Values | None = None
) -> System:
    """A system of shipped components."""
    files = FmuStore("native").files(kinds.values())
    parts = {each: component(each, files[kind], (values or {}).get(each)) for each, kind in kinds.items()}
    found = connected(parts, wires)
    return System(name, parts, found, DefaultExperiment(0.0, 4500.0, 5.0))


def chain() -> System:
    """Two motors, each with a link, side by side."""
    return system("Chain", CHAIN, CHAIN_WIRES, {"duty": _duty(SEGMENTS)})


def cell() -> System:
    """One motor with a link, for a short time."""
    whole = system("Cell", CELL, CELL_WIRES, {"duty": _duty(((600.0, 3.4, 4.0), (900.0, 1.0, 0.0)))})
    return replace(whole, default_experiment=DefaultExperiment(0.0, 1500.0, 7.5))


def spindle(folder: Path) -> Path:
    """FMU of a spindle, built in a folder."""
    from pythonfmu.builder import FmuBuilder

    script = folder / "spindle_of_a_stranger.py"
    script.write_text(SPINDLE, "utf-8")
    return Path(FmuBuilder.build_FMU(str(script), dest=str(folder), needsExecutionTool="false"))


def machine(fmu: Path) -> System:
    """A foreign spindle on a column of ours."""
    kinds = {"duty": "DutyCycle", "column": "ThermalLink"}
    files = FmuStore("native").files(kinds.values())
    values = {"duty": _duty(((1500.0, 6.0, 0.0), (900.0, 0.0, 0.0), (1200.0, 3.0, 0.0)))}
    parts = {name: component(name, files[kind], values.get(name)) for name, kind in kinds.items()}
    parts["spindle"] = component("spindle", fmu)
    wires = (
        ("duty.speed", "spindle.speed"),
        ("duty.ambient_temperature", "spindle.room"),
        ("duty.ambient_temperature", "column.ambient_temperature"),
        ("spindle.heat", "column.heat_flow"),
        ("column.base_temperature", "spindle.column"),
    )
    found = connected(parts, wires)
    return System("Machine", parts, found, DefaultExperiment(0.0, 3600.0, 5.0))


MACHINE_COLUMNS = {
    "speed [1]": "spindle.speed",
    "room [degC]": "column.ambient_temperature",
    "spindle [1]": "spindle.temperature",
    "base [degC]": "column.base_temperature",
    "tip [degC]": "column.tip_temperature",
}


def _duty(segments: Sequence[tuple[float, float, float]]) -> dict[str, Value]:
    duty: dict[str, Value] = {}
    for i, (duration, speed, torque) in enumerate(segments, start=1):
        duty |= {f"duration[{i}]": duration, f"segment_speed[{i}]": speed, f"segment_torque[{i}]": torque}
    return duty


def measured(
    truth: System, columns: Mapping[str, str], noise: float, seed: int, row: float = 15.0, step: float = 0.25
) -> dict[str, np.ndarray]:
    """Columns of a run; readings have a noise in K (1 sigma)."""
    random = np.random.default_rng(seed)
    stop = truth.default_experiment.stop_time or 3600.0
    sources = {each.target: each.source for each in truth.connections}
    recorded = {header: sources.get(name, name) for header, name in columns.items()}
    result = simulate(truth, stop, step, GaussSeidel(), record=list(recorded.values()), check_stability=False)
    every = round(row / step)
    found = {"time [s]": result.times[::every]}
    for header, name in recorded.items():
        values = result[name][::every]
        if header.endswith("[degC]"):
            values = values - 273.15
        if not header.startswith(INPUT_HEADERS):
            values = values + noise * random.standard_normal(values.size)
        found[header] = values
    return found


def write_csv(columns: Mapping[str, np.ndarray], path: Path) -> None:
    """Write a run."""
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, "%.6g", ",", header=",".join(columns), comments="")


def with_values(of: System, values: Values) -> System:
    """The same with other start values."""
    parts = {n: replace(p, values={**p.values, **values.get(n, {})}) for n, p in of.components.items()}
    return replace(of, components=parts)


def experiment(folder: Path, of: System, columns: Mapping[str, str], causes: str, more: str = "") -> Path:
    """An experiment on a system with causes of its own, in a folder."""
    write_ssp(of, folder / "system.ssp")
    (folder / "causes.toml").write_text(causes, "utf-8")
    channels = "\n".join(f'"{header}" = "{variable}"' for header, variable in columns.items())
    (folder / "experiment.toml").write_text(
        f'system = "system.ssp"\n{more}\n[[run]]\ndata = "run.csv"\n[channels]\n{channels}\n'
        '[causes]\nfile = "causes.toml"\nshipped = false\n',
        "utf-8",
    )
    return folder / "experiment.toml"

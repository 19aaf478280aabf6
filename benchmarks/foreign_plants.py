"""Plants that warmlink did not make, with thermometers and a growth: an SSP and a file of roles each."""

from __future__ import annotations

import os
import shutil
import subprocess
import zipfile
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import fmpy
import numpy as np

from benchmarks.own_systems import spindle
from warmlink.fmus.errors import InputError
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.system.assemble import component, connected
from warmlink.orchestration.system.model import DefaultExperiment, System, Value
from warmlink.orchestration.system.write import write_ssp

SCREW = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Real

START = {
    Fmi2Causality.input: {"speed": 0.0, "load": 0.0, "room": 295.15},
    Fmi2Causality.parameter: {"emissivity": 0.9, "expansion": 11.5e-6},
    Fmi2Causality.output: {"bearing": 295.15, "nut": 295.15, "frame": 295.15, "growth": 0.0},
}
SIGMA = 5.67e-8


class Screw(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.shaft = 295.15
        for causality, values in START.items():
            for name, value in values.items():
                setattr(self, name, value)
                self.register_variable(Real(name, causality=causality))

    def lost(self, temperature, area):
        rise = temperature - self.room
        free = 3.0 * abs(rise) ** 0.25 * rise
        return area * (free + self.emissivity * SIGMA * (temperature**4 - self.room**4))

    def do_step(self, time, step):
        for _ in range(4):
            h = step / 4
            friction = 0.6 * self.speed**2 / (1 + 0.01 * (self.bearing - 295.15))
            rubbing = 1.2 * abs(self.speed * self.load)
            along = 1.6 * (self.bearing - self.shaft), 1.1 * (self.shaft - self.nut)
            down = 0.5 * (self.bearing - self.frame)
            self.bearing += h * (friction - along[0] - down - self.lost(self.bearing, 0.02)) / 700
            self.shaft += h * (along[0] - along[1] - self.lost(self.shaft, 0.05)) / 1500
            self.nut += h * (rubbing + along[1] - self.lost(self.nut, 0.03)) / 900
            self.frame += h * (down - self.lost(self.frame, 0.3)) / 9000
        warm = [each - 295.15 for each in (self.bearing, self.shaft, self.nut, self.frame)]
        self.growth = self.expansion * (0.1 * warm[0] + 0.35 * warm[1] + 0.15 * warm[2] - 0.2 * warm[3])
        return True
"""
"""Source of an FMU: a ball screw with four temperatures, free convection and radiation, in SI."""

SWAYING = SCREW.replace(
    "return True", "self.growth = 3e-5 * math.sin(time / 700)\n        return True"
).replace("from pythonfmu", "import math\n\nfrom pythonfmu", 1)
"""The same, but that its growth sways with time and with nothing that anybody sees."""

CAPACITIES = np.array([800.0, 1200.0, 4000.0])
ALONG, LOST = np.array([1.5, 0.8]), np.array([0.2, 0.5, 1.0])
GROWING = np.array([2.7, 5.4, -1.2]) * 1e-6
"""A rod of two pieces on a base: J/K, W/K, W/K and m/K."""

ROLES = """
title = "{name}"
system = "{name}.ssp"
duty = "{duty}"
stop_time = "2 h"
step_size = "5 s"
tolerance = "5 um"
controller = "none"

[roles]
speed = {speed}
torque = {torque}
ambient_temperature = {room}
score = "{growth} - compensator.correction"

[sensors]
noise = "0.1 K"
"""
CHANNEL = {"shaft": 1, "winding": 2, "base": 3, "middle": 4, "tip": 5}


@dataclass(frozen=True)
class ForeignPlant:
    """A plant: how its FMU is made in a folder, and what its variables are.

    Attributes
    ----------
    read : variable behind each thermometer that the controller reads
    speed, torque, room : inputs that the duty cycle drives
    growth : the output that is scored
    parts, wires, values : components of ours beside it, connections, and start values of the FMU
    """

    made: Callable[[Path], Path]
    read: Mapping[str, str]
    speed: tuple[str, ...]
    room: tuple[str, ...]
    growth: str
    torque: tuple[str, ...] = ()
    parts: Mapping[str, str] = field(default_factory=dict)
    wires: tuple[tuple[str, str], ...] = ()
    values: Mapping[str, Value] = field(default_factory=dict)

    @property
    def sensors(self) -> list[str]:
        """Names of the thermometers."""
        return list(self.read)

    def written(self, name: str, folder: Path, duty: str = "stop_and_go") -> Path:
        """Write the SSP and, beside it, the file of its roles, whose path is given."""
        kinds = {"sensors": "TemperatureSensors", "compensator": "LagCompensator", **self.parts}
        files = FmuStore("native").files(kinds.values())
        parts = {each: component(each, files[kind]) for each, kind in kinds.items()}
        parts["plant"] = component("plant", self.made(folder), self.values)
        wires = [*self.wires]
        for place, source in self.read.items():
            wires.append((source, f"sensors.temperature[{CHANNEL[place]}]"))
            wires.append((f"sensors.reading[{CHANNEL[place]}]", f"compensator.{place}_temperature"))
        system = System(name, parts, connected(parts, wires), DefaultExperiment(0.0, 7200.0, 5.0))
        write_ssp(system, folder / f"{name}.ssp", version="2.0")
        return self.scenario(name, folder, duty)

    def scenario(self, name: str, folder: Path, duty: str) -> Path:
        """Write the file of the roles in a duty cycle."""
        room = [*self.room, "compensator.ambient_temperature", "sensors.ambient_temperature"]
        text = ROLES.format(
            name=name,
            duty=duty,
            speed=_listed(*self.speed, "compensator.speed"),
            torque=_listed(*self.torque, "compensator.torque"),
            room=_listed(*room),
            growth=self.growth,
        )
        path = folder / f"{name}_{duty}.toml"
        path.write_text(text, "utf-8")
        return path


def _listed(*names: str) -> str:
    return str(list(names)).replace("'", '"')


def screw(folder: Path, source: str = SCREW) -> Path:
    """FMU of the ball screw, built in a folder.

    Its module has a name of its own for each source: pythonfmu imports one of a name in a process.
    """
    from pythonfmu.builder import FmuBuilder

    script = folder / f"ball_screw_{zlib.crc32(source.encode()):08x}.py"
    script.write_text(source, "utf-8")
    return Path(FmuBuilder.build_FMU(str(script), dest=str(folder), needsExecutionTool="false"))


def state_space(folder: Path) -> Path:
    """The StateSpace of the Reference-FMUs, built from the checkout that REFERENCE_FMUS names.

    Its description says that it steps by 1 s, and its source by 1 ms, which takes half a minute a run: it is
    built as the description says.

    Raises
    ------
    InputError
        There is no such checkout, or no gcc.
    """
    source, compiler = Path(os.environ.get("REFERENCE_FMUS", "")), shutil.which("gcc")
    if compiler is None or not (source / "StateSpace").is_dir():
        raise InputError(
            "name a checkout of github.com/modelica/Reference-FMUs in REFERENCE_FMUS; it needs gcc"
        )
    library, model = folder / f"StateSpace{fmpy.sharedLibraryExtension}", folder / "StateSpace"
    shutil.copytree(source / "StateSpace", model, dirs_exist_ok=True)
    config = (model / "config.h").read_text("utf-8")
    (model / "config.h").write_text(config.replace("FIXED_SOLVER_STEP 1e-3", "FIXED_SOLVER_STEP 1"), "utf-8")
    files = [model / "model.c", *(source / "src" / f"{name}.c" for name in ("fmi3Functions", "cosimulation"))]
    flags = ["-O1", "-fPIC", "-shared", "-w", "-DFMI_VERSION=3", "-DDISABLE_PREFIX"]
    folders = [f"-I{source / 'include'}", f"-I{model}"]
    subprocess.run([compiler, *flags, *folders, *files, "-o", library, "-lm"], check=True)
    with zipfile.ZipFile(folder / "StateSpace.fmu", "w") as archive:
        archive.write(source / "StateSpace/FMI3.xml", "modelDescription.xml")
        archive.write(library, f"binaries/{fmpy.platform_tuple}/{library.name}")
    return folder / "StateSpace.fmu"


def rod_values() -> dict[str, Value]:
    """A rod on a base as matrices, of which no thermometer sees the base.

    Inputs are speed, room and 1; outputs two temperatures and the growth. The states are rises, as they begin
    at 0 whatever x0 is set to.
    """
    a, b, c, d = (np.zeros((3, 3)) for _ in "abcd")
    for i, conductance in enumerate(ALONG):
        a[[i, i + 1], [i, i + 1]] -= conductance
        a[[i, i + 1], [i + 1, i]] += conductance
    a -= np.diag(LOST)
    b[0, 0], b[:, 1], b[:, 2] = 3.0, LOST, -295.15 * LOST
    c[[0, 1], [0, 1]], c[2] = 1.0, GROWING
    d[:2, 2] = 295.15
    matrices = {"A": a / CAPACITIES[:, None], "B": b / CAPACITIES[:, None], "C": c, "D": d}
    values: dict[str, Value] = {"u[1]": 0.0, "u[2]": 295.15, "u[3]": 1.0}
    for name, found in matrices.items():
        values |= {f"{name}[{i + 1},{j + 1}]": float(each) for (i, j), each in np.ndenumerate(found)}
    return values


_OF_SCREW = {"shaft": "plant.bearing", "base": "plant.nut", "tip": "plant.frame"}
_BALL_SCREW = ForeignPlant(
    screw, _OF_SCREW, ("plant.speed",), ("plant.room",), "plant.growth", torque=("plant.load",)
)

PLANTS: Mapping[str, ForeignPlant] = {
    "rod": ForeignPlant(
        state_space,
        {"base": "plant.y[1]", "tip": "plant.y[2]"},
        ("plant.u[1]",),
        ("plant.u[2]",),
        "plant.y[3]",
        values=rod_values(),
    ),
    "ball screw": _BALL_SCREW,
    "spindle on a column": ForeignPlant(
        spindle,
        {"base": "column.base_temperature", "tip": "column.tip_temperature"},
        ("plant.speed", "column.speed"),
        ("plant.room", "column.ambient_temperature"),
        "column.elongation",
        parts={"column": "ThermalLink"},
        wires=(("plant.heat", "column.heat_flow"), ("column.base_temperature", "plant.column")),
    ),
}
"""Plants by name: of FMI 3 in C, of Python, and of Python beside a component of ours."""

"""The hour that a host of plain C runs, in any emulator, and the same hour of the Python instance."""

from __future__ import annotations

import math
import subprocess
from pathlib import Path

from fmpy import extract, read_model_description

from warmlink.fmus.component import Component, Input
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.packaging.native.compile import Compiler
from warmlink.fmus.packaging.native.fmu import header_folder

HERE = Path(__file__).parent
STEPS, STEP = 3600, 1.0
LEVEL = {"heat_flow": 5.0, "speed": 3.0}
AMPLITUDE = {"heat_flow": 4.0, "ambient_temperature": 2.0, "speed": 1.0}


def compile_host(compiler: Compiler, version: str, folder: Path, suffix: str = "", *flags: str) -> Path:
    """The C host as a program for the compiler's platform."""
    source = HERE / "drivers" / f"host_fmi{version[0]}.c"
    assert len(source.read_text().splitlines()) < 100
    target = folder / f"host{version[0]}{suffix}"
    command = [*compiler.command, "-std=gnu99", "-O1", "-Wall", "-Werror", f"-I{header_folder()}", *flags]
    libraries = ["-lm"] if compiler.platform.suffix == ".dll" else ["-ldl", "-lm"]
    done = subprocess.run(
        [*command, str(source), "-o", str(target), *libraries], capture_output=True, text=True, cwd=folder
    )
    assert done.returncode == 0, done.stderr
    return target


def arguments(component: Component, fmu: Path, library: str, folder: Path) -> list[str]:
    """Arguments of the host; the library lies at a path inside the FMU."""
    extract(str(fmu), str(folder))
    description = read_model_description(str(folder), validate=False)
    starts = ",".join(
        f"{s.reference}:{LEVEL.get(s.name, s.start)!r}:{AMPLITUDE.get(s.name, 0.0)!r}"
        for s in component.scalars()
        if isinstance(s.variable, Input) and s.variable.type == "Real"
    )
    first = component.p.size + component.u.size
    outputs = ",".join(str(first + i) for i in range(component.y.size))
    return [str(folder / library), description.guid, str(STEPS), repr(STEP), starts, outputs]


def hour_in_python(component: Component) -> list[float]:
    """Outputs of the Python instance after the same hour."""
    instance = Instance(component)
    instance.begin()
    instance.initialize()
    inputs = [s for s in component.scalars() if isinstance(s.variable, Input) and s.variable.type == "Real"]
    for i in range(STEPS):
        for k, scalar in enumerate(inputs):
            swing = AMPLITUDE.get(scalar.name, 0.0) * math.sin(i * STEP / 600 + k)
            level = LEVEL.get(scalar.name, scalar.start)
            assert level is not None
            instance.set({scalar.name: level + swing})
        instance.step(i * STEP, STEP)
    return [instance.get(name) for name in component.y.names]

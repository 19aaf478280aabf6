"""How long a step takes: native FMU, Python FMU, and the generated step alone in a loop of plain C."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.command import start
from warmlink.fmus.catalogue import Entry, catalogue
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.python.fmu import build_python_fmus
from warmlink.orchestration.arm.chain import arm_chain
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.console import answer, answer_json
from warmlink.orchestration.machine.shipped import WARMUP_CELL

_LOOP = Path(__file__).with_suffix(".c")
_NATIVE_STEPS, _PYTHON_STEPS = 50_000, 300


@dataclass(frozen=True)
class StepTimes:
    """Times of one communication step of a component, in µs: the best of several runs.

    Attributes
    ----------
    component : its name
    step : communication step size in s
    bare : the generated step alone, in a loop of C; 0 for a component without states
    native : through FMI 2.0, from C: inputs set, step, one output got
    python : the same calls on the Python FMU; None for a joined component, which has none
    instance_bytes : memory of an instance of the native FMU
    """

    component: str
    step: float
    bare: float
    native: float
    python: float | None
    instance_bytes: int


def bench_fmus(entries: Iterable[Entry] | None = None) -> Iterator[StepTimes]:
    """Build and time components one after the other, their own step sizes and start values.

    Parameters
    ----------
    entries : components; where none are given all there are, the cell in one piece, and the plant of the arm

    Raises
    ------
    InputError
        If there is no C compiler, or the system loads libraries otherwise than POSIX does.
    """
    if sys.platform == "win32":
        raise InputError("the benchmark's C loop loads libraries as POSIX does; run it on Linux or macOS")
    for entry in entries if entries is not None else [*catalogue(), *_joined()]:
        with tempfile.TemporaryDirectory(prefix="warmlink-") as work:
            yield _times(entry, Path(work))


def times_table(times: Iterable[StepTimes]) -> str:
    """Times as lines of text."""
    lines = [f"{'µs a step':24}{'step':>8}{'bare C':>9}{'native':>9}{'python':>9}{'faster':>8}{'memory':>10}"]
    for each in times:
        bare = f"{each.bare:.3f}" if each.bare else "-"
        python = (
            f"{each.python:>9.1f}{each.python / each.native:>7.0f}x" if each.python else f"{'-':>9}{'-':>8}"
        )
        lines.append(
            f"{each.component:24}{each.step:>6g} s{bare:>9}{each.native:>9.3f}{python}"
            f"{each.instance_bytes / 1024:>6.1f} KiB"
        )
    return "\n".join(lines)


def _joined() -> Iterator[Entry]:
    """The warm-up cell with the law `lag`, and the arm's six motors and six links without anything else."""
    home = "warmlink.orchestration.system"
    yield Entry(WARMUP_CELL.joined(controller("lag")), home)
    arm = arm_chain(compensated=False)
    others = [name for name, kind in arm.parts.items() if kind not in ("MotorHeatSource", "ThermalLink")]
    yield Entry(replace(arm.without(*others).joined(), name="ArmPlant"), home)


def _times(entry: Entry, work: Path) -> StepTimes:
    from fmpy import read_model_description

    from warmlink.fmus.packaging.native.compile import compilers, platforms_named
    from warmlink.fmus.packaging.native.fmu import header_folder, native_fmu_files, native_sources

    component = entry.component
    (compiler,) = compilers(platforms_named(None))
    files = native_fmu_files(entry, "2.0", [compiler])
    library = work / "library.so"
    library.write_bytes(next(content for path, content in files.items() if path.startswith("binaries/")))
    sources, _ = native_sources(component, "2.0")
    for name, text in sources.items():
        (work / name).write_text(text, encoding="utf-8")
    units = ("starting.c", "running.c", "variables.c")
    command = [*compiler.command, *compiler.flags[1:], f"-I{header_folder()}", "-I.", str(_LOOP), *units]
    subprocess.run([*command, "-o", "bench", "-ldl", "-lm"], cwd=work, check=True, capture_output=True)

    (work / "modelDescription.xml").write_bytes(files["modelDescription.xml"])
    guid = read_model_description(str(work), validate=False).guid
    step = component.default_step_size
    loop = subprocess.run(
        [str(work / "bench"), str(library), guid, str(_NATIVE_STEPS), repr(step)],
        check=True,
        capture_output=True,
        text=True,
    )
    native, bare = map(float, loop.stdout.split())
    python = None if component.joint else _python_time(entry, work)
    return StepTimes(
        component.name, step, bare, native, python, _instance_bytes(sources, work, compiler.command)
    )


def _python_time(entry: Entry, work: Path) -> float:
    """Time in µs of a step of the Python FMU, best of a few runs."""
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    component = entry.component
    (python_fmu,) = build_python_fmus([entry], work / "python")
    folder = work / "python_fmu"
    extract(str(python_fmu), str(folder))
    description = read_model_description(str(folder), validate=False)
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=str(folder),
        modelIdentifier=component.name,
        instanceName="bench",
    )
    slave.instantiate()
    slave.setupExperiment()
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    inputs = [s for s in component.scalars() if s.variable in component.inputs and s.variable.type == "Real"]
    references, values = [s.reference for s in inputs], [s.start for s in inputs]
    output = [component.p.size + component.u.size]
    step, reached, best = component.default_step_size, 0, float("inf")
    for _ in range(3):
        began = time.perf_counter()
        for i in range(reached, reached + _PYTHON_STEPS):
            slave.setReal(references, values)
            slave.doStep(i * step, step)
            slave.getReal(output)
        best = min(best, (time.perf_counter() - began) / _PYTHON_STEPS)
        reached += _PYTHON_STEPS
    slave.terminate()
    slave.freeInstance()
    return best * 1e6


def _instance_bytes(sources: dict[str, str], work: Path, compiler: tuple[str, ...]) -> int:
    """Size of the structure that an instance is, and of its name."""
    (work / "size.c").write_text(
        '#include <stdio.h>\n#include "model.h"\nint main(void) { printf("%zu", sizeof(Model)); return 0; }\n'
    )
    subprocess.run([*compiler, "-I.", "size.c", "-o", "size"], cwd=work, check=True, capture_output=True)
    done = subprocess.run([str(work / "size")], check=True, capture_output=True, text=True)
    return int(done.stdout)


def main(json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False) -> None:
    """Time one communication step of each component: native FMU, Python FMU, bare C loop."""
    times = list(bench_fmus())
    if json:
        answer_json([asdict(each) for each in times])
    else:
        answer(times_table(times))


if __name__ == "__main__":
    start(main)

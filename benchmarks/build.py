"""What building costs from an empty cache, and how the systems' steps compare with another checkout's."""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from benchmarks.command import start
from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import answer, answer_json

if TYPE_CHECKING:
    from fmpy.fmi2 import FMU2Slave

_ROUNDS, _STEPS, _STEP = 15, 400, 1.0
"""Paired runs, communication steps in each, and their size in s."""

_BUILD = """
import os, resource, sys
from warmlink.orchestration.cli import main

sys.argv[0] = "warmlink"
try:
    main()
finally:
    times = os.times()
    print(times.user + times.system, times.children_user + times.children_system,
          resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss, file=sys.stderr)
"""
"""The command, and what it took: this process, those it started, and the largest of these."""


@dataclass(frozen=True)
class Cost:
    """What a build took.

    Attributes
    ----------
    what : names that were given to `warmlink build`, or all
    python, compilers : processor time in s, of the command itself and of the compilers
    compiler_memory : of the largest compiler process in MB
    """

    what: str
    python: float
    compilers: float
    compiler_memory: float


@dataclass(frozen=True)
class Pair:
    """A communication step of one system here and in another checkout, in µs, and the median of ratios."""

    system: str
    here: float
    there: float
    ratio: float


def build_cost(names: list[str], out: Path) -> Cost:
    """Build from an empty cache into a folder; InputError if that fails."""
    import os

    with tempfile.TemporaryDirectory(prefix="warmlink-") as cache:
        command = [sys.executable, "-c", _BUILD, "build", *names, "--out", str(out)]
        environment = {**os.environ, "WARMLINK_CACHE": cache}
        done = subprocess.run(command, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise InputError(f"warmlink build {' '.join(names)}: {done.stderr.strip() or 'failed'}")
    python, compilers, memory = map(float, done.stderr.split()[-3:])
    return Cost(" ".join(names) or "all", python, compilers, memory / 1024)


def paired_steps(here: Path, there: Path) -> Pair:
    """Step two native FMUs (FMI 2.0) of a system in turns, in processor time of this process."""
    with tempfile.TemporaryDirectory(prefix="warmlink-") as work:
        both = [_slave(fmu, Path(work) / str(i)) for i, fmu in enumerate((here, there))]
        spent: list[list[float]] = [[], []]
        for k in range(_ROUNDS):
            for slave, times in zip(both, spent, strict=True):
                began = time.process_time()
                for i in range(k * _STEPS, (k + 1) * _STEPS):
                    slave.doStep(i * _STEP, _STEP)
                times.append((time.process_time() - began) / _STEPS * 1e6)
        for slave in both:
            slave.terminate()
            slave.freeInstance()
    ratio = statistics.median(a / b for a, b in zip(*spent, strict=True))
    return Pair(here.stem, min(spent[0]), min(spent[1]), ratio)


def _slave(fmu: Path, folder: Path) -> FMU2Slave:
    """Instance of an FMU, initialized."""
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    if not fmu.is_file():
        raise InputError(
            f"{fmu}: no such file; give the folder that another checkout's `warmlink build` wrote"
        )
    extract(str(fmu), str(folder))
    description = read_model_description(str(folder), validate=False)
    slave = FMU2Slave(
        guid=description.guid, unzipDirectory=str(folder), modelIdentifier=fmu.stem, instanceName=fmu.stem
    )
    slave.instantiate()
    slave.setupExperiment()
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    return slave


def main(
    against: Annotated[
        Path | None, typer.Option(help="Folder that another checkout's build wrote, to compare steps with.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Build all and ThermalLink alone from an empty cache, and compare steps with another checkout's."""
    with tempfile.TemporaryDirectory(prefix="warmlink-") as work:
        costs = [build_cost(names, Path(work) / str(len(names))) for names in ([], ["ThermalLink"])]
        native = Path("native") / "fmi2"
        names = [] if against is None else ["WarmupCell.fmu", "SixAxisArm.fmu"]
        pairs = [paired_steps(Path(work) / "0" / native / n, Path(against or "") / native / n) for n in names]
    if json:
        answer_json({"costs": [asdict(each) for each in costs], "steps": [asdict(each) for each in pairs]})
        return
    heads = f"{'Python':>9}{'compilers':>11}{'together':>10}{'largest compiler':>19}"
    answer(f"{'processor time in s':24}{heads}")
    for each in costs:
        times = f"{each.python:9.1f}{each.compilers:11.1f}{each.python + each.compilers:10.1f}"
        answer(f"{each.what:24}{times}{each.compiler_memory:16.0f} MB")
    for pair in pairs:
        answer(f"{pair.system}: a step {pair.here:.2f} µs, there {pair.there:.2f} µs, ratio {pair.ratio:.3f}")


if __name__ == "__main__":
    start(main)

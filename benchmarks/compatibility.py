"""Which tool runs what of a build, and to how many digits it agrees with ours; only what runs is told."""

from __future__ import annotations

import math
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any

import typer

from benchmarks.command import start
from benchmarks.hosts import HOSTS, Job
from benchmarks.masters import Case, Row, timed
from benchmarks.public_files import seen as public_files
from benchmarks.public_page import files_section, version
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging import release
from warmlink.orchestration.console import answer
from warmlink.orchestration.files import temporary_folder
from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.description import read_description

STEPS = 300
"""Of 1 s."""

FINE = 0.05
"""s, of the steps in which hosts that integrate are compared: after a jump a step of 1 s is 1e-4 off."""

SYSTEMS = {
    "WarmupCell.ssp": "link.elongation",
    "BenchRod.ssp": "link.elongation",
    "BenchMotor.ssp": "motor.shaft_temperature",
    "SixAxisArm-flat.ssp": "axis1_link.elongation",
    "WarmupCell-ports.ssp": "link.elongation",
    "SixAxisArm.ssp": "axis1.link.elongation",
}
"""An output to compare in each; the last two are for other uses, and mostly refused."""

FORMS = ("native/fmi2", "native/fmi3", "python")
OUTSIDE = ("libcosimpy", "ecospy", "FMPy", "pyssp-standard", "fmu-manipulation-toolbox", "OMSimulator")


_PYSSP = """
import sys
from pyssp_standard.ssd import SSD
from pyssp_standard.ssp import SSP
with SSP(sys.argv[1], mode="r") as ssp, SSD(ssp.unpacked_path / "SystemStructure.ssd", mode="r") as ssd:
    ssd.__check_compliance__()
"""


@dataclass(frozen=True)
class Seen:
    """What a tool made of a file."""

    tool: str
    file: str
    started: str
    outcome: str


def agreement(value: float, ours: float) -> str:
    """How far two numbers agree, in words."""
    if value == ours:
        return "equal to the last bit"
    if not (math.isfinite(value) and ours):
        return f"{value:g} where ours is {ours:g}"
    return f"agrees to {max(0, math.floor(-math.log10(abs(value / ours - 1)))):d} digits"


def seen(dist: Path) -> Iterator[Seen]:
    """Let every installed tool at a build.

    Parameters
    ----------
    dist : folder that `warmlink build` wrote

    Raises
    ------
    InputError
        If the folder holds no build.
    """
    missing = [name for name in (*SYSTEMS, *FORMS) if not (dist / name).exists()]
    if missing:
        raise InputError(f"{dist}: holds no {missing[0]}; run warmlink build --out {dist}")
    for form in FORMS:
        fmus = sorted((dist / form).glob("*.fmu"))
        yield from _fmus(form, [fmu for fmu in fmus if fmu.stem != "SixAxisArm"])
    for name, watched in SYSTEMS.items():
        yield from _masters(dist / name, watched)
    yield from _ssp_tools(dist)


def _fmus(form: str, fmus: Sequence[Path]) -> Iterator[Seen]:
    """Single FMUs: validated, stepped, integrated, checked."""
    from fmpy.validation import validate_fmu

    files = f"{form}/*.fmu ({len(fmus)})"
    yield Seen(
        "FMPy", files, "`validate_fmu`", _all({fmu: "; ".join(validate_fmu(str(fmu))) for fmu in fmus})
    )
    if form != "python":
        yield Seen("FMPy", files, "`simulate_fmu`, co-simulation", _all({f: _stepped(f) for f in fmus}))
    for fmu in fmus if form != "python" else ():
        difference = _integrated(fmu)
        if difference is not None:
            told = f"within {difference:.0e} of its co-simulation in steps of {FINE:g} s"
            yield Seen("FMPy", f"{form}/{fmu.name}", "`simulate_fmu`, model exchange with CVode", told)
    tool = Path(sys.executable).with_name("fmutool")
    if tool.is_file():
        checked = {fmu: _complaint([str(tool), "-input", str(fmu), "-check"]) for fmu in fmus}
        yield Seen("FMU Manipulation Toolbox", files, "`fmutool -check`", _all(checked))


def _all(complaints: dict[Path, str]) -> str:
    bad = [f"{fmu.stem}: {complaint}" for fmu, complaint in complaints.items() if complaint]
    return f"{len(bad)} of {len(complaints)} complained of, as {bad[0]}" if bad else "nothing found"


def _complaint(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    lines = (done.stdout + done.stderr).splitlines()
    return next((line for line in lines if line.startswith(("ERROR", "WARNING", "CRITICAL"))), "")


def _simulated(fmu: Path, kind: str, step: float = 1.0, **options: Any) -> Any:
    from fmpy import simulate_fmu

    return simulate_fmu(str(fmu), fmi_type=kind, stop_time=float(STEPS), output_interval=step, **options)


def _stepped(fmu: Path) -> str:
    result = _simulated(fmu, "CoSimulation")
    return "" if len(result) == STEPS + 1 else f"{len(result)} points"


def _integrated(fmu: Path) -> float | None:
    """Largest difference between both kinds, as a share of each output's largest value; None without both."""
    from fmpy import read_model_description

    description = read_model_description(str(fmu))
    if description.modelExchange is None:
        return None
    moved = {"on": 1.0, "heat_flow": 5.0, "speed": 3.43, "torque": 2.5}
    inputs = {v.name for v in description.modelVariables if v.causality == "input"}
    starts = {name: value for name, value in moved.items() if name in inputs}
    a = _simulated(fmu, "CoSimulation", FINE, start_values=starts)
    b = _simulated(fmu, "ModelExchange", FINE, start_values=starts, solver="CVode", relative_tolerance=1e-10)
    names = [name for name in a.dtype.names if name not in ("time", "discretisation_error")]
    return max(float(abs(a[name] - b[name]).max() / (abs(a[name]).max() or 1.0)) for name in names)


def _masters(path: Path, watched: str) -> Iterator[Seen]:
    with temporary_folder() as work:
        system = read_system(path, work)
        instance, _, variable = watched.rpartition(".")
        reference = read_description(system.components[instance].fmu).variables[variable].value_reference
    case = Case(path.name, Job(str(path), STEPS, 1.0, watched, reference))
    hosts = {host.name: host for host in HOSTS}
    ours = timed(case, hosts["warmlink, plain"])
    if path.name == "WarmupCell.ssp":
        yield Seen("FMPy", path.name, "`simulate_ssp`", _by_fmpy(case, ours))
    for name, started in (("libcosim", "`from_ssp_file`"), ("Ecos", '`init(parameter_set="parameters")`')):
        if not hosts[name].missing:
            yield Seen(name, path.name, started, _compared(timed(case, hosts[name]), ours))


def _by_fmpy(case: Case, ours: Row) -> str:
    from fmpy.ssp.simulation import simulate_ssp

    theirs = simulate_ssp(case.job.ssp, stop_time=float(STEPS), step_size=1.0)[case.job.watched][-1]
    share = abs(float(theirs) / (ours.value or math.nan) - 1)
    return f"{100 * share:.1f} % off, for its first step takes 0 for every input; applies no parameter sets"


def _compared(theirs: Row, ours: Row) -> str:
    if theirs.value is None or ours.value is None:
        return f"refused: {theirs.failure or ours.failure}"
    return agreement(theirs.value, ours.value)


def _ssp_tools(dist: Path) -> Iterator[Seen]:
    if version("pyssp-standard"):
        for name in SYSTEMS:
            with tempfile.TemporaryDirectory(prefix="warmlink-") as work:
                # It writes into what it opens.
                copy = shutil.copy(dist / name, work)
                done = subprocess.run(
                    [sys.executable, "-c", _PYSSP, copy], capture_output=True, text=True, check=False
                )
            bad = [line for line in done.stderr.splitlines() if line.startswith("Reason")]
            told = "nothing found" if not done.returncode else (bad or done.stderr.splitlines()[-1:])[0]
            yield Seen("pyssp-standard", name, "`SSD(FILE, mode='r')`, schema check", told)
    if shutil.which("OMSimulator"):
        for name in SYSTEMS:
            done = subprocess.run(
                ["OMSimulator", str(dist / name), f"--stopTime={STEPS}"],
                capture_output=True,
                text=True,
                check=False,
            )
            bad = [line for line in done.stdout.splitlines() if line.startswith("error")]
            yield Seen("OMSimulator", name, "`OMSimulator FILE`", bad[0] if bad else "runs")
    tool = Path(sys.executable).with_name("fmucontainer")
    if tool.is_file():
        yield Seen(
            "FMU Manipulation Toolbox",
            "WarmupCell-ports.ssp",
            "`fmucontainer`, run by FMPy",
            _contained(dist, tool),
        )


def _contained(dist: Path, tool: Path) -> str:
    """The cell in one container, driven as the cell by itself is: the same master algorithm."""
    with tempfile.TemporaryDirectory(prefix="warmlink-") as work:
        shutil.copy(dist / "WarmupCell-ports.ssp", work)
        made = subprocess.run(
            [str(tool), "-container", "WarmupCell-ports.ssp:1"], cwd=work, capture_output=True, check=False
        )
        if made.returncode:
            return "refused"
        starts = {"speed": 3.43, "torque": 2.5}
        result = _simulated(Path(work) / "WarmupCell-ports.fmu", "CoSimulation", start_values=starts)
    cell = Case("cell", Job(str(dist / "WarmupCell.ssp"), STEPS, 1.0, "link.elongation", 0))
    ours = timed(cell, HOSTS[0])
    return ours.failure or agreement(float(result["elongation"][-1]), ours.value or 0.0)


OPERATING_SYSTEMS = {"Linux": "Linux", "Windows": "Windows", "Darwin": "macOS"}
"""Their names, by what Python calls them."""


def page(rows: Sequence[Seen], others: Sequence[str] = ()) -> str:
    """Text of the page, in Markdown."""
    versions = {"warmlink": release.version(), **{package: version(package) for package in OUTSIDE}}
    found = ", ".join(f"{package} {number}" for package, number in versions.items() if number)
    absent = ", ".join(package for package, number in versions.items() if not number)
    others = [name for key, name in OPERATING_SYSTEMS.items() if key != platform.system()]
    lines = [
        "# What ran where",
        "",
        "Written in the checkout by `python -m benchmarks.compatibility dist` on "
        f"{datetime.now(UTC):%Y-%m-%d} with Python "
        f"{platform.python_version()} on {platform.system()} {platform.machine()}, from what "
        f"`warmlink build` had written. Systems ran {STEPS} steps of 1 s.",
        "",
        f"Installed: {found}." + (f" Not installed, hence not run: {absent}." if absent else ""),
        f"Not run either: Simulink, Dymola, and any of this on {' and '.join(others)}.",
        "",
        "| tool | file | started by | what came of it |",
        "|---|---|---|---|",
    ]
    told = [f"| {r.tool} | {r.file} | {r.started} | {r.outcome} |" for r in rows]
    return "\n".join([*lines, *told, *others]) + "\n"


def main(
    dist: Annotated[Path, typer.Argument(help="What `warmlink build` wrote.")] = Path("dist"),
    out: Annotated[Path, typer.Option(help="The page to write.")] = Path("docs/compatibility.md"),
    files: Annotated[Path | None, typer.Option(help="Folder of other people's FMUs and SSPs.")] = None,
) -> None:
    """Let the tools that are installed at a build, run other people's files, and write what came of it."""
    rows, found = [], []
    for row in seen(dist):
        answer(f"{row.tool:26}{row.file:28}{row.outcome}")
        rows.append(row)
    for each in public_files([files]) if files else ():
        answer(f"{each.outcome:28}{each.file}  {' '.join(each.said.split())[:200]}")
        found.append(each)
    out.write_text(page(rows, files_section(found, files) if files else ()), encoding="utf-8")


if __name__ == "__main__":
    start(main)

"""Other people's files, run by us and by another master: `python -m benchmarks.public_files FOLDER`.

FMUs are run by FMPy too, systems by libcosim, with the same steps, the inputs' start values, and libcosim's
algorithm. It counts whether a number differs without a word.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from benchmarks.command import start
from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import answer, print_table
from warmlink.orchestration.files import temporary_folder
from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import DefaultExperiment, FmuPart, System
from warmlink.orchestration.system.write import write_ssp

MOST_STEPS = 1000
SAME = 1e-6
"""Of the largest value of an output."""

SECONDS = 60.0
"""For one run."""

TIGHT = 1e-10
"""Relative tolerance of the solvers that integrate models for model exchange, ours and FMPy's."""

SETTLED = {
    "LinearTransformation3/SystemStructure.ssd": (
        "libcosim leaves out the values bound at the system; OMSimulator's own test expects ours, 182"
    ),
    "algebraic_loop/algebraic_loop_1.ssp": "the same FMUs stepped one by one with FMPy give ours",
    "linear_transformation/SystemStructure.ssd": (
        "libcosim applies the sets of one name alone; by SSP 5.2.3 the later of two bindings counts"
    ),
}
"""Files, by the end of their path, on which the other master is known to be wrong, and from whom."""

OUTCOMES = (
    "same numbers",
    "same to the FMU's tolerance",
    "differs, settled by a third",
    "differs, with a word",
    "DIFFERS WITHOUT A WORD",
    "runs here alone",
    "refused with a sentence",
    "REFUSED WITHOUT A SENTENCE",
    "refused by both",
)
BAD = [each for each in OUTCOMES if each.isupper()]

Columns = Mapping[str, list[float]]


@dataclass(frozen=True)
class Seen:
    """What came of one file: one of `OUTCOMES`, what was said, and the largest difference between the two.

    The difference is a share of an output's largest value; None where only one ran. The `kind` is that of
    the file, as `FMI 2.0 co-simulation`.
    """

    file: Path
    outcome: str
    said: str
    difference: float | None = None
    kind: str = ""


@dataclass(frozen=True)
class Ran:
    """A run: the outputs' values by name, None if it was refused, and what was said."""

    columns: Columns | None
    said: str


def ours(ssp: Path, stop: float, step: float, work: Path, tolerance: float | None = None) -> Ran:
    """Run a system by the command."""
    command = [sys.executable, "-m", "warmlink", "simulate", str(ssp), "--no-error-budget", "--no-csv"]
    options = ["--stop", f"{stop!r} s", "--step", f"{step!r} s", "--master", "jacobi"]
    options += ["--out", str(work / "ours")]
    options += [] if tolerance is None else ["--fmu-tolerance", f"{tolerance:g}"]
    try:
        done = subprocess.run(
            [*command, *options], capture_output=True, text=True, timeout=SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        return Ran(None, f"warmlink: no end within {SECONDS:g} s")
    table = work / "ours" / "results.parquet"
    # FMUs print, too.
    ours = ("warmlink: ", "Traceback")
    said = "\n".join(line for line in done.stderr.splitlines() if line.startswith(ours))
    if done.returncode == 2 or not table.is_file():
        return Ran(None, said)
    import pandas as pd

    frame = pd.read_parquet(table)
    if len(frame) < 2 and done.returncode:
        return Ran(None, said)
    return Ran({name.rpartition(" [")[0]: frame[name].tolist() for name in frame}, said)


def theirs(job: Mapping[str, Any], work: Path) -> Ran:
    """Run a file by another master, in a process of its own."""
    asked, answered = work / "asked.json", work / "answered.json"
    asked.write_text(json.dumps(job), encoding="utf-8")
    command = [sys.executable, "-m", "benchmarks.public_references", str(asked), str(answered)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        return Ran(None, f"no end within {SECONDS:g} s")
    if not answered.is_file():
        return Ran(None, (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1])
    return Ran(json.loads(answered.read_text("utf-8")), "")


def steps_of(proposed: DefaultExperiment) -> tuple[float, float, int]:
    """Stop time and step in s, and how many: as proposed, but no more than `MOST_STEPS`."""
    duration = (proposed.stop_time or proposed.start_time + 1.0) - proposed.start_time
    step = proposed.step_size or duration / 100
    count = max(1, min(MOST_STEPS, round(duration / step)))
    return proposed.start_time + count * step, step, count


def fmu_seen(path: Path, work: Path) -> Seen:
    """Run one FMU by us and by FMPy."""
    asked = {"by": "fmpy", "file": str(path), "tolerance": None}
    try:
        info = read_description(path)
    except InputError as fault:
        reference = theirs({**asked, **_times(DefaultExperiment()), "names": None}, work)
        return judged(path, Ran(None, f"warmlink: {fault}"), reference)
    kinds = {name: info.variables[name].kind for name in info.outputs if name in info.variables}
    names = [name for name, kind in kinds.items() if kind in ("Real", "Integer", "Boolean", "Enumeration")]
    arrays = {name for name in names if info.variables[name].elements > 1}
    names = [name for name in names if name not in arrays]
    tolerance = TIGHT if info.interface == "ModelExchange" else None
    times = _times(info.default_experiment)
    ssp = work / "one.ssp"
    experiment = DefaultExperiment(info.default_experiment.start_time, times["stop"])
    try:
        write_ssp(System("one", {"fmu": FmuPart("fmu", path)}, (), experiment), ssp)
        own = ours(ssp, times["stop"], times["step"], work, tolerance)
    except InputError as fault:
        own = Ran(None, f"warmlink: {fault}")
    reference = theirs({**asked, **times, "tolerance": tolerance, "names": names}, work)
    if own.columns is not None:
        found = {name.removeprefix("fmu."): values for name, values in own.columns.items()}
        own = Ran({name: found[name] for name in names if name in found}, own.said)
    seen = judged(path, own, reference, info.default_experiment.tolerance or 0.0)
    interface = "model exchange" if tolerance else "co-simulation"
    return replace(seen, kind=f"FMI {info.fmi_version} {interface}")


def system_seen(path: Path, work: Path) -> Seen:
    """Run one system by us and by libcosim, and compare the ends."""
    try:
        system = read_system(path, work / "read")
    except InputError as fault:
        return judged(path, Ran(None, f"warmlink: {fault}"), _libcosim(path, {}, DefaultExperiment(), work))
    ends: dict[str, tuple[str, int]] = {}
    for name, held in system.components.items():
        info = read_description(held.fmu)
        real = [o for o in info.outputs if info.variables[o].kind == "Real" and info.fmi_version != "3.0"]
        ends |= {f"{name}.{output}": (name, info.variables[output].value_reference) for output in real}
    times = _times(system.default_experiment)
    own = ours(path, times["stop"], times["step"], work)
    if own.columns is not None:
        own = Ran({name: own.columns[name][-1:] for name in ends if name in own.columns}, own.said)
    seen = judged(path, own, _libcosim(path, ends, system.default_experiment, work))
    return replace(seen, kind=f"system of {len(system.components)} FMUs")


def _times(proposed: DefaultExperiment) -> dict[str, float]:
    stop, step, count = steps_of(proposed)
    return {"start": proposed.start_time, "stop": stop, "step": step, "steps": count}


def _libcosim(path: Path, ends: Mapping[str, Any], proposed: DefaultExperiment, work: Path) -> Ran:
    place = path.parent if path.suffix == ".ssd" else path
    return theirs({"by": "libcosim", "file": str(place), **_times(proposed), "references": ends}, work)


def judged(path: Path, own: Ran, reference: Ran, tolerance: float = 0.0) -> Seen:
    """Say what came of a file.

    The tolerance is that of a solver inside an FMU. A step that is longer by a rounding error than the
    distance of two points, as ours may be and FMPy's is not, has such a solver begin anew.
    """
    if own.columns is None:
        sentence = own.said.startswith("warmlink: ") and "Traceback" not in own.said
        outcome = "refused with a sentence" if sentence else "REFUSED WITHOUT A SENTENCE"
        return Seen(path, "refused by both" if reference.columns is None and sentence else outcome, own.said)
    if reference.columns is None:
        return Seen(path, "runs here alone", f"{own.said} (there: {reference.said})")
    ended = "asks to end the simulation" in own.said
    worst, name = max(
        (
            (_distance(values, reference.columns[n], ended), n)
            for n, values in own.columns.items()
            if n in reference.columns
        ),
        default=(0.0, ""),
    )
    if worst <= SAME:
        return Seen(path, "same numbers", own.said, worst)
    told = f"{name} by {worst:.2g}; {own.said}"
    if worst <= tolerance:
        return Seen(path, "same to the FMU's tolerance", told, worst)
    for end, why in SETTLED.items():
        if path.as_posix().endswith(end):
            return Seen(path, "differs, settled by a third", f"{told} {why}", worst)
    return Seen(path, "differs, with a word" if own.said else "DIFFERS WITHOUT A WORD", told, worst)


def _distance(a: list[float], b: list[float], ended: bool = False) -> float:
    """Largest difference, as a share of the largest value; infinite if one has more rows or is not finite.

    Where the FMU has `ended` the simulation, FMPy leaves out the last row.
    """
    if ended and len(a) == len(b) + 1:
        a = a[:-1]
    if len(a) != len(b):
        return np.inf
    first, second = np.array(a, dtype=float), np.array(b, dtype=float)
    if not np.array_equal(np.isfinite(first), np.isfinite(second)):
        return np.inf
    known = np.isfinite(first)
    size = float(np.max(np.abs(second[known]), initial=0.0)) or 1.0
    return float(np.max(np.abs(first - second)[known], initial=0.0)) / size


def seen(folders: list[Path]) -> Iterator[Seen]:
    """Run every FMU and system in folders; InputError if one is no folder."""
    for folder in folders:
        if not folder.is_dir():
            raise InputError(
                f"{folder}: no such folder; give one with .fmu, .ssp or SystemStructure.ssd files"
            )
        for path in sorted(folder.rglob("*")):
            kind = "system" if path.suffix == ".ssp" or path.name == "SystemStructure.ssd" else path.suffix
            if kind in ("system", ".fmu"):
                with temporary_folder() as work:
                    yield (system_seen if kind == "system" else fmu_seen)(path, work)


def main(folders: Annotated[list[Path], typer.Argument(help="Folders with files from other tools.")]) -> None:
    """Count what comes of the files; exit code 1 if numbers differ, or a file is refused, without a word."""
    counts: Counter[str] = Counter()
    for each in seen(folders):
        counts[each.outcome] += 1
        answer(f"{each.outcome:28}{each.file}  {' '.join(each.said.split())[:240]}")
    rows = [(outcome, str(counts[outcome])) for outcome in OUTCOMES]
    print_table(f"{counts.total()} files", ("outcome", "files"), rows, texts=1)
    if any(counts[outcome] for outcome in BAD):
        raise SystemExit(1)


if __name__ == "__main__":
    start(main)

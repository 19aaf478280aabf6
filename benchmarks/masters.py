"""Masters side by side: the same systems, the same FMUs, the same algorithm and step, in one run."""

from __future__ import annotations

import json as json_text
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.command import start
from benchmarks.hosts import HOSTS, Finished, Host, Job
from benchmarks.hosts.__main__ import MARK
from benchmarks.trivial_fmu import build_trivial_fmu
from benchmarks.whole_run import bench_whole_run
from warmlink.fmus.errors import InputError
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.console import answer, answer_json, remark
from warmlink.orchestration.fmu_store import FMU_KINDS, FmuStore
from warmlink.orchestration.scenarios.duties.duty import Duty
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import Connection, DefaultExperiment, FmuPart, System
from warmlink.orchestration.system.write import write_ssp

ELONGATION = "link.elongation"

TIME_LIMIT = 600.0
"""For one process, in s."""


@dataclass(frozen=True)
class Extent:
    """How much is run: steps of the trivial system, steps of 1 s of the cell, and how often each process."""

    trivial_steps: int = 100_000
    cell_steps: int = 3600
    rounds: int = 2


@dataclass(frozen=True)
class Case:
    """A system that all masters run; `truth` is what the watched output would be without coupling error."""

    name: str
    job: Job
    truth: float | None = None


@dataclass(frozen=True)
class Row:
    """What a master came to on a case: the best of the rounds.

    Attributes
    ----------
    master, case : names
    step_us : wall time of a communication step in µs
    process_s : wall time of the whole process, its start included, in s
    value : last value of the watched output
    off_by : difference of that from the solution without coupling error; None where there is none
    failure : why there are no figures
    """

    master: str
    case: str
    step_us: float | None = None
    process_s: float | None = None
    value: float | None = None
    off_by: float | None = None
    failure: str | None = None


def bench_masters(
    extent: Extent | None = None, told: Callable[[str], None] | None = None
) -> Iterator[list[Row]]:
    """Run every case with every master that is installed; gives the rows of a case when it is done.

    The masters take turns, round by round, so that a busy moment of the machine hits all of them.

    Parameters
    ----------
    extent : how much is run
    told : called with the name of each process before it starts

    Raises
    ------
    InputError
        If there is no C compiler for the trivial FMU and the native ones.
    """
    chosen = extent or Extent()
    if min(chosen.trivial_steps, chosen.cell_steps) < 3 or chosen.rounds < 1:
        raise InputError(f"{chosen}: too little to time; give 3 steps or more and 1 round or more")
    with tempfile.TemporaryDirectory(prefix="warmlink-") as work:
        for case in _cases(chosen, Path(work)):
            there = [host for host in HOSTS if not host.missing]
            fit = [host for host in there if case.truth is not None or not host.iterates]
            yield _rows(case, fit, chosen.rounds, told or (lambda name: None))


def absent() -> dict[str, tuple[str, ...]]:
    """Masters that cannot be timed here, each with the packages that are not installed."""
    return {host.name: host.missing for host in HOSTS if host.missing}


def _rows(case: Case, hosts: Sequence[Host], rounds: int, told: Callable[[str], None]) -> list[Row]:
    best: dict[str, Row] = {}
    for _ in range(rounds):
        for host in hosts:
            told(f"{case.name}: {host.name}")
            row = timed(case, host)
            old = best.get(host.name, row)
            best[host.name] = row if row.failure is not None else _better(row, old)
    return list(best.values())


def _better(row: Row, old: Row) -> Row:
    if old.failure is not None or row.step_us is None or old.step_us is None:
        return old
    assert row.process_s is not None
    assert old.process_s is not None
    return Row(
        row.master,
        row.case,
        min(row.step_us, old.step_us),
        min(row.process_s, old.process_s),
        row.value,
        row.off_by,
    )


def timed(case: Case, host: Host) -> Row:
    """Run a case with one master, in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.hosts", host.function]
    began = time.perf_counter()
    try:
        done = subprocess.run(
            [*command, json_text.dumps(asdict(case.job))],
            cwd=Path(__file__).parents[1],
            capture_output=True,
            text=True,
            timeout=TIME_LIMIT,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return Row(host.name, case.name, failure=f"not done within {TIME_LIMIT:g} s")
    took = time.perf_counter() - began
    answers = [line.removeprefix(MARK) for line in done.stdout.splitlines() if line.startswith(MARK)]
    if not answers:
        lines = [line for line in done.stderr.splitlines() if line.strip()]
        return Row(host.name, case.name, failure=lines[-1] if lines else f"exit code {done.returncode}")
    found = Finished(**json_text.loads(answers[0]))
    off_by = None if case.truth is None else found.value - case.truth
    return Row(host.name, case.name, found.step_us, took, found.value, off_by)


def _cases(extent: Extent, work: Path) -> Iterator[Case]:
    trivial = trivial_system(build_trivial_fmu(work), extent.trivial_steps)
    yield _case(trivial, f"three trivial FMUs of C, {extent.trivial_steps} steps", "c.y", work)
    truth = elongation_without_coupling_error(extent.cell_steps)
    for kind in FMU_KINDS:
        wiper = load_scenario("windshield_wiper")
        cell = wiper.system(wiper.files(FmuStore(kind)))
        cell = _lasting(cell, extent.cell_steps)
        folder = work / kind
        folder.mkdir()
        yield _case(
            cell, f"warm-up cell, {kind} FMUs, {extent.cell_steps} steps of 1 s", ELONGATION, folder, truth
        )


def _case(system: System, name: str, watched: str, folder: Path, truth: float | None = None) -> Case:
    path = folder / f"{system.name}.ssp"
    write_ssp(system, path)
    instance, _, variable = watched.partition(".")
    about = read_description(system.components[instance].fmu).variables[variable]
    experiment = system.default_experiment
    assert experiment.stop_time is not None
    assert experiment.step_size is not None
    steps = round(experiment.stop_time / experiment.step_size)
    return Case(name, Job(str(path), steps, experiment.step_size, watched, about.value_reference), truth)


def _lasting(system: System, steps: int) -> System:
    return replace(system, default_experiment=DefaultExperiment(0.0, float(steps), 1.0))


def trivial_system(fmu: Path, steps: int) -> System:
    """Three trivial slaves in a row, with five connections: two real numbers, two integers, a Boolean.

    Each integrates what it is given. The last value of Jacobi with held inputs is (n - 1)(n - 2) / (6 n**2)
    after n steps.
    """
    given = {"rate": 1.0 / steps}
    parts = {name: FmuPart(name, fmu, {}, dict(given)) for name in "abc"}
    wires = (
        Connection("a", "y", "b", "u"),
        Connection("b", "y", "c", "u"),
        Connection("a", "steps", "b", "switched"),
        Connection("b", "steps", "c", "switched"),
        Connection("b", "off", "c", "on"),
    )
    return System("Trivial", parts, wires, DefaultExperiment(0.0, float(steps), 1.0))


def elongation_without_coupling_error(seconds: int) -> float:
    """Elongation in m of the cell under the windshield wiper, motor and link solved as one system."""
    from warmlink.fmus.component.reference import integrate
    from warmlink.fmus.plant import demand, plant

    duty = load_scenario("windshield_wiper").duty
    assert isinstance(duty, Duty)
    first = duty.segments[0]
    phase = demand(float(seconds), first.speed, first.torque, first.ambient_temperature)
    found = integrate(plant(), [phase], [ELONGATION], every=float(seconds), tolerance=1e-11)
    return float(found.values[ELONGATION][-1])


def masters_table(rows: Sequence[Row]) -> str:
    """Rows of one case as text; ratios are to the fastest."""
    fastest = min((row.step_us for row in rows if row.step_us is not None), default=1.0)
    known = any(row.off_by is not None for row in rows)
    head = f"{'':24}{'µs a step':>11}{'ratio':>9}{'process':>10}"
    lines = [rows[0].case, head + (f"{'elongation':>16}{'off by':>13}" if known else f"{'last value':>16}")]
    for row in rows:
        if row.step_us is None or row.process_s is None or row.value is None:
            lines.append(f"{row.master:24}  failed: {row.failure}")
            continue
        line = f"{row.master:24}{row.step_us:>11.3g}{row.step_us / fastest:>8.1f}x{row.process_s:>8.2f} s"
        if row.off_by is None:
            line += f"{row.value:>16.9g}"
        else:
            line += f"{1e6 * row.value:>13.6f} µm{1e9 * row.off_by:>10.4f} nm"
        lines.append(line)
    return "\n".join(lines)


def main(
    rounds: Annotated[int, typer.Option(help="Runs of each; the best counts.")] = 2,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Time our master beside FMPy's loop, libcosim, Ecos and what else is installed, on the same FMUs.

    Three trivial FMUs of C with five connections, then an hour of the warm-up cell with native and with
    Python FMUs: time of a communication step and of the whole process, elongation, and what it is off by.
    """
    told = remark if sys.stderr.isatty() else (lambda name: None)
    found = []
    for rows in bench_masters(Extent(rounds=rounds), told):
        found += rows
        if not json:
            answer(masters_table(rows) + "\n")
    whole = bench_whole_run(rounds)
    if json:
        answer_json({"rows": [asdict(row) for row in found], **asdict(whole), "not_installed": absent()})
        return
    answer(f"{whole}\n")
    answer("off by: from motor and link solved as one system of equations (BDF, tolerance 1e-11)")
    for name, packages in absent().items():
        answer(f"not installed: {name} ({', '.join(packages)})")


if __name__ == "__main__":
    start(main)

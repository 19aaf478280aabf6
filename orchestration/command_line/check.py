"""`warmlink check`: the checks that an integrator makes before trusting an FMU or a system."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import FAILED, answer, answer_json, print_table
from warmlink.orchestration.text_files import is_file

if TYPE_CHECKING:
    from warmlink.orchestration.check.fmu import CheckResult
    from warmlink.orchestration.system.model import System

_SIGNS = {"pass": ("pass", "green"), "fail": ("FAIL", "red"), "skip": ("skip", "yellow")}


def check(file: Path, *, json: bool = False) -> None:
    """Check an FMU or a system as its user would check it; the exit code is 1 if a check fails.

    Parameters
    ----------
    file : An .fmu or .ssp file from any tool.
    """
    from rich.text import Text

    from warmlink.orchestration.check.fmu import check_fmu

    if not is_file(file):
        raise InputError(f"{file}: no such file; give an .fmu or .ssp file")
    results = _check_system(file) if file.suffix == ".ssp" else check_fmu(file)
    failed = sum(result.verdict == "fail" for result in results)
    if json:
        answer_json([asdict(result) for result in results])
    else:
        rows = [(result.name, Text(*_SIGNS[result.verdict]), result.detail) for result in results]
        print_table(str(file), ("check", "", "detail"), rows)
        answer(f"{len(results) - failed} of {len(results)} checks found no fault")
    if failed:
        raise SystemExit(FAILED)


def _check_system(path: Path) -> list[CheckResult]:
    """Check a system: that it reads, that each FMU is valid, and that it runs its default experiment."""
    from warmlink.orchestration.check.fmu import CheckResult, validity_problems
    from warmlink.orchestration.files import temporary_folder
    from warmlink.orchestration.system.read import read_system

    with temporary_folder() as work:
        system = read_system(path, work)
        detail = f"{len(system.components)} components, {len(system.connections)} connections"
        results = [CheckResult("reads and fits together", "pass", detail)]
        for name, held in system.components.items():
            found = "; ".join(validity_problems(held.fmu))[:200]
            results.append(CheckResult(f"{name} is valid", "fail" if found else "pass", found))
        return [*results, _run(system)]


def _run(system: System) -> CheckResult:
    """Check that the system runs its default experiment."""
    from warmlink.orchestration.check.fmu import CheckResult
    from warmlink.orchestration.master.slaves.slave import SlaveError
    from warmlink.orchestration.simulation import simulate

    stop = system.default_experiment.stop_time
    if stop is None:
        return CheckResult("runs", "skip", "the system proposes no stop time")
    try:
        run = simulate(system)
    except SlaveError as fault:
        return CheckResult("runs", "fail", str(fault))
    done = "; ".join((f"{stop:g} s in steps of {run.table.points.step_size:g} s", *run.remarks))
    return CheckResult("runs", "fail" if run.reason else "pass", run.reason or done)

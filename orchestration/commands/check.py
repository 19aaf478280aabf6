"""`warmlink check`: what an integrator checks before trusting a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.check import CheckResult, check_fmu
from warmlink.orchestration.commands.console import answer, answer_json
from warmlink.orchestration.files import temporary_folder
from warmlink.orchestration.master.guard import guarded
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slave import SlaveError
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.read import read_system
from warmlink.orchestration.text_files import is_file

FAILED = 1
_SIGNS = {"pass": "[green]pass[/]", "fail": "[red]FAIL[/]", "skip": "[yellow]skip[/]"}


def check_command(path: Path, as_json: bool) -> int:
    """Check and print a table; gives the exit code."""
    if not is_file(path):
        raise InputError(f"{path}: no such file; give an .fmu or .ssp file")
    results = check_system_file(path) if path.suffix == ".ssp" else check_fmu(path)
    failed = sum(result.verdict == "fail" for result in results)
    if as_json:
        answer_json([asdict(result) for result in results])
    else:
        _print_table(path, results)
        answer(f"{len(results) - failed} of {len(results)} checks without a fault")
    return FAILED if failed else 0


def check_system_file(path: Path) -> list[CheckResult]:
    """Check a system: that it reads, that each FMU is valid, and that it runs its default experiment."""
    from fmpy.validation import validate_fmu

    results = []
    with temporary_folder() as work:
        system = read_system(path, work)
        detail = f"{len(system.components)} components, {len(system.connections)} connections"
        results.append(CheckResult("reads and fits together", "pass", detail))
        for name, held in system.components.items():
            problems = validate_fmu(str(held.fmu))
            found = "; ".join(problems)[:200]
            results.append(CheckResult(f"{name} is valid", "fail" if problems else "pass", found))
        experiment = system.default_experiment
        if experiment.stop_time is None:
            results.append(CheckResult("runs", "skip", "the system proposes no stop time"))
            return results
        step = experiment.step_size or experiment.stop_time / 500
        results.append(_run(system, experiment.start_time, experiment.stop_time, step))
    return results


def _run(system: System, start: float, stop: float, step: float) -> CheckResult:
    try:
        run = guarded(lambda line: simulate(system, stop, step, start_time=start, line=line))
    except SlaveError as fault:
        return CheckResult("runs", "fail", str(fault))
    done = "; ".join((f"{stop:g} s in steps of {step:g} s", *run.remarks))
    return CheckResult("runs", "fail" if run.reason else "pass", run.reason or done)


def _print_table(path: Path, results: Sequence[CheckResult]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(title=str(path), title_justify="left", box=None)
    for heading in ("check", "", "detail"):
        table.add_column(heading)
    for result in results:
        table.add_row(result.name, _SIGNS[result.verdict], result.detail)
    Console().print(table)

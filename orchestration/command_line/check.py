"""`warmlink check`: an FMU or a system checked as its users would check it."""

from __future__ import annotations

import shlex
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import FAILED, answer, answer_json, print_table
from warmlink.orchestration.files import temporary_folder
from warmlink.orchestration.master.slaves.slave import SlaveError

if TYPE_CHECKING:
    from warmlink.orchestration.check.fmu import CheckResult

_SIGNS = {
    "pass": ("pass", "green"),
    "fail": ("FAIL", "red"),
    "skip": ("skip", "yellow"),
    "remark": ("note", "yellow"),
}


def check(file: Path, *, time_limit: str | None = None, json: bool = False) -> None:
    """Check an FMU or a system as its user would check it; the exit code is 1 if a check fails.

    Parameters
    ----------
    file : An .fmu or .ssp file from any tool.
    time_limit : Longest time that one check of an FMU may take. Default: "30 s".
    """
    from rich.text import Text

    from warmlink.orchestration.check.fmu import TIME_LIMIT, check_fmu
    from warmlink.orchestration.scenarios.quantities import positive

    if file.is_dir():
        raise InputError(_folder(file))
    limit = TIME_LIMIT if time_limit is None else positive(time_limit, "s", "--time-limit")
    results = _check_system(file) if file.suffix == ".ssp" else check_fmu(file, limit)
    failed = sum(result.verdict == "fail" for result in results)
    if json:
        answer_json([asdict(result) for result in results])
    else:
        rows = [(result.name, Text(*_SIGNS[result.verdict]), result.detail) for result in results]
        print_table(str(file), ("check", "", "detail"), rows)
        answer(f"{len(results) - failed} of {len(results)} checks found no fault")
    if failed:
        raise SystemExit(FAILED)


_NAMED = 5
"""Files of a folder, at most, that a sentence names."""


def _folder(folder: Path) -> str:
    """Say what a folder holds that can be checked."""
    if (folder / "modelDescription.xml").is_file():
        return f"{folder}: is an unpacked FMU; pack it into a zip archive named .fmu"
    files = sorted(path for kind in ("fmu", "ssp") for path in folder.rglob(f"*.{kind}"))
    if not files:
        return f"{folder}: is a folder without .fmu or .ssp files; give the path of one"
    names = ", ".join(str(path.relative_to(folder)) for path in files[:_NAMED])
    more = f" and {len(files) - _NAMED} more" if len(files) > _NAMED else ""
    one = shlex.quote(str(files[0]))
    return f"{folder}: is a folder, which holds {names}{more}; check one of them: warmlink check {one}"


def _check_system(path: Path) -> list[CheckResult]:
    """Check a system: that it reads, that each FMU is valid, and that it runs its default experiment."""
    from warmlink.orchestration.check.fmu import CheckResult, validity_problems
    from warmlink.orchestration.simulation import simulate
    from warmlink.orchestration.system.assemble import read_system

    with temporary_folder() as work:
        system = read_system(path, work)
        detail = f"{len(system.components)} components, {len(system.connections)} connections"
        results = [CheckResult("reads and fits together", "pass", detail)]
        for name, held in system.components.items():
            found = "; ".join(validity_problems(held.fmu))[:200]
            results.append(CheckResult(f"{name} is valid", "fail" if found else "pass", found))
        stop = system.default_experiment.stop_time
        if stop is None:
            return [*results, CheckResult("runs", "skip", "the system proposes no stop time")]
        try:
            run = simulate(system)
        except SlaveError as fault:
            return [*results, CheckResult("runs", "fail", str(fault))]
    done = "; ".join((f"{stop:g} s in steps of {run.table.points.step_size:g} s", *run.remarks))
    return [*results, CheckResult("runs", "fail" if run.stopped else "pass", run.stopped or done)]

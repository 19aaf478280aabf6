"""What an integrator checks before trusting an FMU, whoever made it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from warmlink.fmus.errors import InputError

Verdict = Literal["pass", "fail", "skip"]

TIME_LIMIT = 120.0
"""s, for one check; an FMU that does not answer is left and the next check made."""

_LOADING = "loads in a bare process"


@dataclass(frozen=True)
class CheckResult:
    """What one check found.

    Attributes
    ----------
    name : of the check
    verdict : "pass", "fail", or "skip" where the FMU does not claim what would be checked
    detail : what was seen
    """

    name: str
    verdict: Verdict
    detail: str


def check_fmu(
    path: Path, time_limit: float = TIME_LIMIT, cases: Sequence[str] | None = None
) -> list[CheckResult]:
    """Check an FMU of FMI 2.0 or 3.0 for co-simulation; its code runs in processes of their own.

    Parameters
    ----------
    path : the FMU
    time_limit : s, for one check
    cases : names of the checks to make that run the FMU (see `inspection.cases`), all where none are given

    Raises
    ------
    InputError
        If the file is no FMU for co-simulation that can be read.
    """
    from fmpy import extract, read_model_description
    from fmpy.validation import validate_fmu

    from warmlink.fmus.packaging.inspection.cases import CASES

    description = _description(path, read_model_description)
    problems = list(validate_fmu(str(path)))
    results = [_validity(problems), _platforms(path)]
    with tempfile.TemporaryDirectory(prefix="warmlink-") as work:
        folder = Path(work) / "fmu"
        chosen = list(CASES) if cases is None else list(cases)
        extract(str(path), str(folder))
        library = _library(folder, description)
        if library is None:
            absent = "no library for this machine inside"
            return [*results, *(CheckResult(name, "skip", absent) for name in (_LOADING, *chosen))]
        results.append(_loading(library))
        return results + _run_cases(folder, Path(work), chosen, time_limit)


def _description(path: Path, read: Any) -> Any:
    if not path.is_file():
        raise InputError(f"{path}: no such file; give an FMU")
    if not zipfile.is_zipfile(path):
        raise InputError(f"{path}: not an archive; an FMU is one, with modelDescription.xml in it")
    try:
        description = read(str(path), validate=False)
    except Exception as error:
        reason = str(error).splitlines()[0]
        raise InputError(f"{path}: modelDescription.xml cannot be read: {reason}") from error
    if not description.fmiVersion.startswith(("2.", "3.")) or description.coSimulation is None:
        raise InputError(
            f"{path}: FMI {description.fmiVersion}, without co-simulation or too old; "
            "give an FMU of FMI 2.0 or 3.0 for co-simulation"
        )
    return description


def _validity(problems: list[str]) -> CheckResult:
    if not problems:
        return CheckResult("validates", "pass", "schema and rules of the standard")
    first = " ".join(problems[0].split())
    return CheckResult("validates", "fail", f"{len(problems)} problems: {first}"[:300])


def _platforms(path: Path) -> CheckResult:
    with zipfile.ZipFile(path) as archive:
        parts = [name.split("/") for name in archive.namelist() if name.startswith("binaries/")]
    found = sorted({each[1] for each in parts if len(each) > 2 and each[2]})
    if not found:
        return CheckResult("platforms inside", "fail", "none: the FMU holds no library")
    return CheckResult("platforms inside", "pass", ", ".join(found))


def _library(folder: Path, description: Any) -> Path | None:
    import fmpy

    place = fmpy.platform if description.fmiVersion == "2.0" else fmpy.platform_tuple
    name = description.coSimulation.modelIdentifier + fmpy.sharedLibraryExtension
    library = folder / "binaries" / place / name
    return library if library.is_file() else None


def _loading(library: Path) -> CheckResult:
    """Load the library into a process that holds nothing but the C library, resolving every symbol."""
    if not sys.platform.startswith("linux"):
        return CheckResult(_LOADING, "skip", "made on Linux, whose loader takes any library into any program")
    environment = {"LD_PRELOAD": str(library), "LD_BIND_NOW": "1", "PATH": os.defpath}
    done = subprocess.run(["/bin/true"], env=environment, capture_output=True, text=True, errors="replace")
    if done.returncode == 0 and not done.stderr.strip():
        return CheckResult(_LOADING, "pass", "every symbol found with the C library alone")
    reason = done.stderr.strip().splitlines() or [f"status {done.returncode}"]
    return CheckResult(_LOADING, "fail", reason[0].replace(str(library), library.name).strip())


def _run_cases(folder: Path, work: Path, names: list[str], time_limit: float) -> list[CheckResult]:
    """Make checks in a process; where it dies or hangs, say so and go on with the next in a new one."""
    results: list[CheckResult] = []
    remaining = list(names)
    while remaining:
        journal = work / f"results{len(remaining)}.jsonl"
        journal.touch()
        reason = _run_worker(folder, journal, remaining, time_limit)
        lines = [json.loads(line) for line in journal.read_text(encoding="utf-8").splitlines()]
        done = [CheckResult(*line) for line in lines if len(line) > 1]
        results += done
        remaining = remaining[len(done) :]
        if remaining:
            results.append(CheckResult(remaining.pop(0), "fail", reason))
    return results


def _run_worker(folder: Path, journal: Path, names: list[str], time_limit: float) -> str:
    """Why the process ended, as a sentence for the check that it left unfinished."""
    command = [sys.executable, "-m", "warmlink.fmus.packaging.inspection.worker", str(folder), str(journal)]
    process = subprocess.Popen([*command, *names], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    written = -1
    try:
        while True:
            try:
                _, errors = process.communicate(timeout=time_limit)
                break
            except subprocess.TimeoutExpired:
                size = journal.stat().st_size
                if size == written:
                    process.kill()
                    process.communicate()
                    return f"no answer within {time_limit:g} s"
                written = size
    finally:
        process.kill()
    if process.returncode < 0:
        return f"the process died of {signal.Signals(-process.returncode).name}"
    last = errors.decode("utf-8", "replace").strip().splitlines()
    return f"the process ended with status {process.returncode}: {last[-1] if last else 'no message'}"

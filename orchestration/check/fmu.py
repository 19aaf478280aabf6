"""What an integrator checks before trusting an FMU, whoever made it."""

import ctypes
import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.files import scratch_folder
from warmlink.orchestration.check.cases import CASES, Outcome
from warmlink.orchestration.check.subject import Subject
from warmlink.orchestration.master.slaves.frames import DamagedError, Frames
from warmlink.orchestration.master.slaves.library import SUFFIX, platform_name
from warmlink.orchestration.master.slaves.other_process import START_LIMIT, OtherProcess, ProcessEndedError
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.progress import Progress, unseen
from warmlink.orchestration.system.archive import holds_source_code, unpack
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import ModelInfo

TIME_LIMIT = 30.0
"""s, for one check; an FMU that does not answer is left and the next check made."""

_LOADING = "loads in a bare process"

_IDENTIFIER = r"[A-Za-z_][A-Za-z_0-9]*(\[[0-9]+(,[0-9]+)*\])?"
_STRUCTURED = rf"{_IDENTIFIER}(\.{_IDENTIFIER})*"
PLAIN_NAME = re.compile(rf"{_STRUCTURED}|der\({_STRUCTURED}(,[0-9]+)?\)")
"""Names of variables that either naming convention allows: all but those in quotation marks."""


@dataclass(frozen=True)
class CheckResult:
    """What one check found.

    The verdict is "pass", "fail", "skip" if the FMU does not claim what would be checked, or "remark" if what
    was found is no fault, but good to know.
    """

    name: str
    verdict: str
    detail: str


def check_fmu(
    path: Path,
    time_limit: float = TIME_LIMIT,
    cases: Sequence[str] | None = None,
    progress: Progress = unseen,
) -> list[CheckResult]:
    """Check an FMU; its code runs in processes of their own.

    One check may take `time_limit` s. `cases` are names of the checks that run the FMU (see `CASES`), all by
    default. InputError if the file is no FMU for co-simulation that can be read.
    """
    info = read_description(path)
    progress("validates", 0.0)
    outcomes = {"validates": _validity(path, time_limit), "platforms inside": _platforms(path)}
    chosen = list(CASES if cases is None else cases)
    with scratch_folder() as work:
        folder = unpack(path, work)
        library = _library(folder, info)
        if library is None:
            outcomes |= dict.fromkeys((_LOADING, *chosen), ("skip", "no library for this machine inside"))
        else:
            ran = _run_cases(Subject(info, folder, time_limit / 3), chosen, time_limit, progress)
            outcomes |= {_LOADING: _loading(library, time_limit), **dict(zip(chosen, ran, strict=True))}
    return [CheckResult(name, *outcome) for name, outcome in outcomes.items()]


def _validity(path: Path, time_limit: float) -> Outcome:
    process = OtherProcess("check", _find_problems, path)
    try:
        process.answer(START_LIMIT)
        problems = process.answer(time_limit)
    except TimeoutError:
        return (
            "remark",
            f"FMPy has not judged it within {time_limit:g} s; give a longer {argument('time_limit')}",
        )
    except ProcessEndedError as ended:
        return "remark", f"FMPy could not judge it: its process ended with {ended}"
    finally:
        process.end()
    if not problems:
        return "pass", "schema and rules of the standard"
    return "fail", f"{len(problems)} problems: {' '.join(problems[0].split())}"[:300]


def _platforms(path: Path) -> Outcome:
    with zipfile.ZipFile(path) as archive:
        parts = [name.split("/") for name in archive.namelist() if name.startswith("binaries/")]
    found = sorted({each[1] for each in parts if len(each) > 2 and each[2]})
    if found:
        return "pass", ", ".join(found)
    if holds_source_code(path):
        return "remark", "none: source code alone, as the standard allows; compile it before a run"
    return "fail", "none: the FMU holds no library"


def _library(folder: Path, info: ModelInfo) -> Path | None:
    place = folder / "binaries" / platform_name(f"fmi{info.fmi_version[0]}")
    library = place / f"{info.model_identifier}{SUFFIX}"
    return library if library.is_file() else None


def _find_problems(pipe: Frames, path: Path) -> None:
    pipe.send(validity_problems(path))


def _loading(library: Path, time_limit: float) -> Outcome:
    """Load the library into a process that holds nothing but the C library, resolving every symbol."""
    if not sys.platform.startswith("linux"):
        return "skip", "made on Linux, whose loader takes any library into any program"

    own = f"./{library.name}"  # its folder's name might hold a blank, which ends a name in LD_PRELOAD

    def complaint(command: Sequence[str], *preloaded: str) -> str:
        environment = {"LD_PRELOAD": " ".join(preloaded), "LD_BIND_NOW": "1", "PATH": os.defpath}
        try:
            done = subprocess.run(
                command,
                cwd=library.parent,
                env=environment,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=time_limit,
            )
        except subprocess.TimeoutExpired:
            return f"it has not loaded within {time_limit:g} s"
        told = done.stderr.strip().splitlines() or [f"status {done.returncode}"] * (done.returncode != 0)
        return told[0].replace(own, library.name).strip() if told else ""

    found = complaint(["/bin/true"], own)
    if not found:
        return "pass", "every symbol found with the C library alone"
    symbol = (
        found.rpartition("undefined symbol: ")[2].split()[0].strip(",") if "undefined symbol" in found else ""
    )
    if symbol and not complaint(["/bin/true"], own, "libm.so.6"):
        told = "which nearly every host has loaded; link it with -lm, for a host that has not"
        return "remark", f"does not name libm, whose {symbol} it calls, {told}"
    in_python = "import ctypes, sys; ctypes.CDLL(sys.argv[1])"
    python = [sys.executable, "-S", "-c", in_python, own]
    if hasattr(ctypes.pythonapi, symbol or "?") and not complaint(python):
        told = "a host in Python runs it, any other must load Python's library first"
        return "remark", f"needs Python in the host's process (undefined symbol: {symbol}): {told}"
    return "fail", found


def _run_cases(subject: Subject, names: list[str], time_limit: float, progress: Progress) -> list[Outcome]:
    """Make checks in a process; where it dies or hangs, say so and go on with the next in a new one."""
    outcomes: list[Outcome] = []
    told = subject.folder.parent / "told"
    while len(outcomes) < len(names):
        remaining = names[len(outcomes) :]
        if subject.info.capabilities.once_per_process:
            remaining = remaining[:1]
        process = OtherProcess("check", _make_checks, subject, remaining, told)
        try:
            process.answer(START_LIMIT)
            for name in remaining:
                progress(name, (1 + len(outcomes)) / (1 + len(names)))
                outcomes.append(process.answer(time_limit))
        except DamagedError:
            outcomes.append(("fail", "it writes to descriptors that are not its own"))
        except TimeoutError:
            outcomes.append(("fail", f"no answer within {time_limit:g} s"))
        except ProcessEndedError as ended:
            last = told.read_text("utf-8", "replace").strip().splitlines() or ["no message"]
            how = f"ended with {ended}: {last[-1]}"
            if ended.killed:
                how = f"died of {str(ended).removeprefix('signal ')}"
            outcomes.append(("fail", f"the process {how}"))
        finally:
            process.end()
    return outcomes


def _make_checks(pipe: Frames, subject: Subject, names: list[str], told: Path) -> None:
    """Answer with verdict and detail of each check; what the FMU prints goes to a file."""
    with told.open("wb") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    for name in names:
        try:
            pipe.send(CASES[name](subject))
        except SlaveError as fault:
            early = f"the FMU asks to end at {fault.time:g} s, before the check has"
            asked = fault.asks_to_end_after(subject.start_time)
            pipe.send(("skip", early) if asked else ("fail", str(fault)))
        except InputError as fault:
            pipe.send(("fail", str(fault)))


def validity_problems(path: Path) -> list[str]:
    """What FMPy's `validate_fmu` finds wrong with an FMU; nothing where it is valid.

    FMPy spends nearly all of its time on a grammar of the variables' names, which is left out where all are
    plain.
    """
    from fmpy import read_model_description
    from fmpy.validation import validate_fmu

    try:
        description = read_model_description(str(path), validate_model_structure=True)
    except Exception:  # FMPy raises whatever it meets; `validate_fmu` says the same in sentences
        return validate_fmu(str(path))
    with zipfile.ZipFile(path) as archive:
        backslash = any("\\" in file.orig_filename for file in archive.filelist)
    if backslash or not all(PLAIN_NAME.fullmatch(each.name) for each in description.modelVariables):
        return validate_fmu(str(path))
    return []

"""What a whole `warmlink run` takes, from the start of its process to the end."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from warmlink.fmus.errors import InputError

ARGUMENTS = ("run", "--stop", "1 h", "--no-report")


@dataclass(frozen=True)
class WholeRun:
    """A run of one hour without report, its FMUs built before: the least processor time, in s."""

    process_s: float

    def __str__(self) -> str:
        command = " ".join(f'"{part}"' if " " in part else part for part in ARGUMENTS)
        return f"warmlink {command}: {self.process_s:.2f} s of processor time, FMUs ready"


def bench_whole_run(rounds: int = 5) -> WholeRun:
    """Time the command in processes of their own; the first, which may build FMUs, does not count.

    Raises
    ------
    InputError
        If the command fails, or where the platform does not tell what a child process took.
    """
    try:
        from resource import RUSAGE_CHILDREN, getrusage
    except ImportError:
        raise InputError("warmlink run: this platform does not tell a child's processor time") from None

    def children() -> float:
        usage = getrusage(RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    times = []
    with tempfile.TemporaryDirectory(prefix="warmlink-") as work:
        command = [
            sys.executable,
            "-m",
            "warmlink.orchestration.cli",
            *ARGUMENTS,
            "--out",
            str(Path(work) / "run"),
        ]
        for _ in range(rounds + 1):
            before = children()
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode:
                raise InputError(
                    f"warmlink run: ended with exit code {done.returncode}: {done.stderr.strip()}"
                )
            times.append(children() - before)
    return WholeRun(min(times[1:]))

"""Inputs one after another in a process of its own, which may die of one of them."""

from __future__ import annotations

import multiprocessing
import os
import resource
import shutil
import signal
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from random import Random

from benchmarks.fuzz.nest import emptied, nest, strays
from benchmarks.fuzz.targets import TARGETS

LONGEST_SECONDS = 10.0
"""Of the processor; and six times that on the wall, for what waits."""
MOST_MEGABYTES = 1024.0
"""Of memory that is in use; after an input that took more a new process goes on."""
MOST_BYTES_RESERVED = 8 << 30
"""Of addresses, beyond those at the start; libraries reserve many that they never use."""
START_SECONDS = 120.0
"""For the process and its good files, before the first input."""


@dataclass(frozen=True)
class Finding:
    """What came of one input.

    Attributes
    ----------
    number : of the input
    verdict : `accepted`, `refused`, or what is wrong
    seconds, megabytes : time taken, and the most memory that the process has had in use so far
    """

    number: int
    verdict: str
    seconds: float
    megabytes: float


def given(name: str, seed: int, number: int, folder: Path) -> Path:
    """Write an input of a target into a folder; the same for the same seed and number."""
    return TARGETS[name].written(Random(f"{seed}/{name}/{number}"), folder)


def findings(name: str, seed: int, numbers: range, failing: Path) -> Iterator[Finding]:
    """Try inputs in processes of their own; those that fail are written into a folder."""
    left = numbers
    while left:
        done = 0
        for finding in _of_one_process(name, seed, left):
            done += 1
            if finding.verdict not in ("accepted", "refused"):
                _keep(name, seed, finding, failing)
            yield finding
        left = left[done:]


def _keep(name: str, seed: int, finding: Finding, failing: Path) -> None:
    folder = failing / f"{name.replace(' ', '-')}-{finding.number}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    given(name, seed, finding.number, folder)
    (folder / "verdict.txt").write_text(finding.verdict + "\n", encoding="utf-8")


def _of_one_process(name: str, seed: int, numbers: range) -> Iterator[Finding]:
    """Try inputs until all are tried, or the process has died or been killed of one."""
    ours, theirs = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(
        target=_work, args=(theirs, name, seed, numbers), daemon=True
    )
    process.start()
    theirs.close()
    number = numbers[0]
    try:
        if not ours.poll(START_SECONDS):
            raise RuntimeError(f"{name}: its good files were not made within {START_SECONDS:g} s")
        ours.recv()
        for number in numbers:
            while not (arrived := ours.poll(6 * LONGEST_SECONDS)) and _is_running(process.pid):
                pass  # others have the processor; its own time is limited
            if not arrived:
                yield Finding(number, "hangs", 6 * LONGEST_SECONDS, 0.0)
                return
            finding: Finding = ours.recv()
            yield finding
            if finding.megabytes > MOST_MEGABYTES:
                return
    except EOFError:
        process.join(5.0)
        slow = process.exitcode == -signal.SIGPROF
        verdict = "takes too long" if slow else f"the process died ({process.exitcode})"
        yield Finding(number, verdict, 0.0, 0.0)
    finally:
        process.kill()
        process.join()


def _work(pipe: Connection, name: str, seed: int, numbers: range) -> None:
    os.nice(10)
    target = TARGETS[name]
    target.files()
    # What FMUs and libraries print is none of anybody's business.
    sys.stdout = sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115
    os.dup2(sys.stdout.fileno(), 1)
    os.dup2(sys.stdout.fileno(), 2)
    with nest() as home:
        target.judged(given(name, seed, numbers[0], emptied(home)))  # whatever is imported late
        strays(home)
        _limit_addresses()
        pipe.send(None)
        for number in numbers:
            path = given(name, seed, number, emptied(home))
            signal.setitimer(signal.ITIMER_PROF, LONGEST_SECONDS)  # ends the process
            began = time.perf_counter()
            verdict = target.judged(path)
            seconds = time.perf_counter() - began
            outside = strays(home)
            if outside:
                verdict = f"wrote {', '.join(outside)}"
            megabytes = _most_in_use()
            if megabytes > MOST_MEGABYTES:
                verdict = f"uses more than {MOST_MEGABYTES:g} MB of memory"
            pipe.send(Finding(number, verdict, seconds, megabytes))


def _is_running(pid: int | None) -> bool:
    """Whether a process would go on if it were given the processor, rather than waiting for something."""
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] == "R"
    except OSError:
        return False


def _most_in_use() -> float:
    """The most memory that this process has had in use at once [MB]; `getrusage` counts its parent's too."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(status.partition("VmHWM:")[2].split()[0]) / 1024


def _limit_addresses() -> None:
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + MOST_BYTES_RESERVED
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))

"""Whether tests notice a change of the code: a seeded sample of mutants of some rooms, and who survives.

Each mutant is put into a copy of the project, where the nearest test files run that import it or stand in its
room. One that survives wants a test, is code that nobody needs, or changes nothing that anybody could see.
"""

from __future__ import annotations

import ast
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.command import start
from benchmarks.mutants import Mutant, mutants
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.console import answer
from warmlink.orchestration.progress import progress_bar

ROOT = Path(__file__).parents[1]
ROOMS = {
    "fit": "orchestration/diagnosis/fit",
    "closed_loop": "orchestration/closed_loop",
    "master": "orchestration/master",
    "controllers": "controllers",
}
COPIED = ("fmus", "controllers", "orchestration", "tests", "benchmarks", "docs", "examples", ".typing")
PATH = ".typing"
"""Where Python finds the copy's packages."""

FILES = ("pyproject.toml", "LICENSE", "README.md", "CONTRIBUTING.md", "CHANGELOG.md")

PATIENCE, LEAST_S = 4.0, 60.0
"""A mutant's tests may take so many times as long as before, and so long at least; longer is a hang."""

MOST_TESTS = 6
"""Test files that a mutant is tried with: more would take hours, and those farther away notice little."""

SEED_OF_TESTS = {"WARMLINK_DIAGNOSIS_SEED": "1"}
"""Tests that draw anew in each run draw the same, so that only the change decides."""

KILLED, HUNG, SURVIVED = "killed", "hung", "survived"


@dataclass(frozen=True)
class Change:
    """A mutant of a file, whose path is relative to the project."""

    path: Path
    mutant: Mutant

    def __str__(self) -> str:
        return f"{self.path}:{self.mutant.line}  {self.mutant}"


class Copy:
    """A copy of the project in a folder, in which mutants are tried."""

    def __init__(self, folder: Path) -> None:
        self.home = folder / "warmlink"
        for name in COPIED:
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / name, self.home / name, symlinks=True, ignore=ignored)
        for name in FILES:
            shutil.copy(ROOT / name, self.home)
        self._written = int(time.time())
        self._took: dict[tuple[Path, ...], float] = {}

    @cached_property
    def _imports(self) -> dict[Path, set[str]]:
        """Names of modules that each test file imports."""
        return {path: _imported(path) for path in sorted((self.home / "tests").rglob("test_*.py"))}

    def tests_of(self, path: Path) -> tuple[Path, ...]:
        """Test files of a module: those that import it, nearest and shortest first, then its room's."""
        module = ".".join(("warmlink", *path.with_suffix("").parts))
        room = self.home / "tests" / path.parent

        def distance(test: Path) -> tuple[int, int]:
            shared = len(os.path.commonpath([room, test.parent]))
            return -shared, test.stat().st_size

        importing = [each for each, names in self._imports.items() if module in names]
        nearest = next((each for each in (room, *room.parents) if any(each.glob("test_*.py"))), room)
        beside = [each for each in self._imports if each.parent == nearest]
        near = (*sorted(importing, key=distance), *sorted(beside, key=distance))
        return tuple(dict.fromkeys(near))[:MOST_TESTS]

    def seconds(self, tests: tuple[Path, ...]) -> float:
        """How long tests take as the code is; InputError if they fail."""
        if tests not in self._took:
            begun = time.monotonic()
            ended, told = self._passed(tests, None)
            if ended != 0:
                names = ", ".join(str(each.relative_to(self.home)) for each in tests)
                raise InputError(f"{names}: fail before anything is changed: {told[-300:]}")
            self._took[tests] = time.monotonic() - begun
        return self._took[tests]

    def outcome(self, change: Change) -> str:
        """What becomes of a change: `killed`, `hung` or `survived`."""
        tests = self.tests_of(change.path)
        patience = max(LEAST_S, PATIENCE * self.seconds(tests))
        kept = (self.home / change.path).read_text("utf-8")
        self._write(change.path, change.mutant.source)
        try:
            ended, _ = self._passed(tests, patience)
        finally:
            self._write(change.path, kept)
        return HUNG if ended is None else SURVIVED if ended == 0 else KILLED

    def _write(self, path: Path, source: str) -> None:
        """Write a file with a time of its own: Python would take what it compiled for one of the same."""
        self._written += 2
        (self.home / path).write_text(source, "utf-8")
        os.utime(self.home / path, (self._written, self._written))

    def _passed(self, tests: Sequence[Path], patience: float | None) -> tuple[int | None, str]:
        """Exit code of the tests, None if they take too long, and what they print."""
        environment = {**os.environ, **SEED_OF_TESTS, "PYTHONPATH": str(self.home / PATH)}
        arguments = ["-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider", *map(str, tests)]
        run = subprocess.Popen(
            [sys.executable, *arguments],
            cwd=self.home,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        try:
            told, _ = run.communicate(timeout=patience)
            return run.returncode, told
        except subprocess.TimeoutExpired:
            return None, ""
        finally:
            if run.poll() is None:
                os.killpg(run.pid, signal.SIGKILL)
                run.wait()


def _imported(path: Path) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return found


def sample(room: str, count: int, seed: int) -> list[Change]:
    """So many changes of a room, drawn from all that there are, in the order of the files."""
    files = sorted((ROOT / ROOMS[room]).rglob("*.py"))
    every = [
        Change(path.relative_to(ROOT), each) for path in files for each in mutants(path.read_text("utf-8"))
    ]
    drawn = random.Random(f"{seed} {room}").sample(range(len(every)), min(count, len(every)))
    return [every[i] for i in sorted(drawn)]


def tried(changes: Sequence[Change], folder: Path) -> Iterator[tuple[Change, str]]:
    """What becomes of each change, in a copy of the project; InputError if tests fail without any."""
    copy = Copy(folder)
    for change in changes:
        yield change, copy.outcome(change)


def main(
    seed: Annotated[int, typer.Option(help="Seed of the sample.")] = 1,
    count: Annotated[int, typer.Option(help="Mutants of each room.", min=1)] = 20,
    room: Annotated[
        list[str] | None, typer.Option(help=f"Only this room: {', '.join(ROOMS)}. Repeatable.")
    ] = None,
) -> None:
    """Change the code here and there, run its tests, and print the changes that no test notices.

    The exit code is 1 if one survives.
    """
    rooms = room or list(ROOMS)
    for name in rooms:
        if name not in ROOMS:
            raise InputError(f"--room {name}: no such room; {instead(name, ROOMS)}")
    survived = 0
    for name in rooms:
        drawn, ends, begun = sample(name, count, seed), Counter[str](), time.monotonic()
        with tempfile.TemporaryDirectory() as folder, progress_bar(f"Mutants of {name}") as progress:
            for done, (change, end) in enumerate(tried(drawn, Path(folder)), start=1):
                ends[end] += 1
                progress(done / len(drawn), f"{ends[SURVIVED]} survived")
                if end == SURVIVED:
                    answer(str(change))
        survived += ends[SURVIVED]
        told = ", ".join(f"{ends[end]} {end}" for end in (KILLED, HUNG, SURVIVED))
        answer(f"{name}: {len(drawn)} mutants, {told}; {time.monotonic() - begun:.0f} s")
    if survived:
        raise typer.Exit(1)


if __name__ == "__main__":
    start(main)

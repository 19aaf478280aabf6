"""Whether figures stay the same though files of the cache are damaged: bits flipped, cut short, gone."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Annotated, Any

import typer

from benchmarks.command import start
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.cache import CACHE_VARIABLE
from warmlink.orchestration.console import answer, remark

RUN = ("run", "windshield_wiper", "--controller", "lag", "--stop", "2 min", "--step", "5 s", "--no-report")
KINDS = ("bit", "cut", "gone", "empty")


def figures(cache: Path) -> dict[str, Any] | str:
    """Figures of a run with a cache, or what it said where it did not end in order."""
    with tempfile.TemporaryDirectory(prefix="warmlink-") as folder:
        command = [
            sys.executable,
            "-m",
            "warmlink.orchestration.cli",
            *RUN,
            "--json",
            "--out",
            f"{folder}/out",
        ]
        where = {**os.environ, CACHE_VARIABLE: str(cache)}
        done = subprocess.run(command, env=where, capture_output=True, text=True, check=False)
    if done.returncode:
        return done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return {name: value for name, value in found.items() if name != "wall_seconds"}


def damage(file: Path, kind: str, draw: random.Random) -> None:
    """Damage a file; its time stays, and with a bit its size."""
    content, facts = bytearray(file.read_bytes()), file.stat()
    if kind == "gone":
        file.unlink()
        return
    if kind == "bit":
        content[draw.randrange(len(content))] ^= 1 << draw.randrange(8)
    else:
        del content[draw.randrange(len(content)) if kind == "cut" else 0 :]
    file.write_bytes(content)
    os.utime(file, ns=(facts.st_atime_ns, facts.st_mtime_ns))


def tried(count: int, seed: int, cache: Path) -> Counter[str]:
    """Damage so many files, each before a run, and count what came of the runs."""
    draw, found, whole = random.Random(seed), Counter[str](), figures(cache)
    if isinstance(whole, str):
        raise InputError(f"the run does not even work undisturbed: {whole}")
    for _ in range(count):
        files = sorted(path for path in cache.rglob("*") if path.is_file() and path.stat().st_size)
        file, kind = draw.choice(files), draw.choice(KINDS)
        damage(file, kind, draw)
        now = figures(cache)
        found["same" if now == whole else "failed" if isinstance(now, str) else "differs"] += 1
        if now != whole:
            remark(f"{file.relative_to(cache)}, {kind}: {now if isinstance(now, str) else 'other figures'}")
    return found


def main(
    count: Annotated[int, typer.Option(help="Files that are damaged, one before each run.")] = 100,
    seed: Annotated[int, typer.Option(help="The same seed draws the same files.")] = 1,
) -> None:
    """Damage one file of the cache after another, and run a scenario after each.

    The figures must be those of an undisturbed run, without any help. Exit code 1 where they are not.
    """
    if count < 1:
        raise InputError(f"--count {count}: give a number above 0")
    with tempfile.TemporaryDirectory(prefix="warmlink-") as home:
        found = tried(count, seed, Path(home) / "cache")
    counts = ", ".join(f"{kind} {found[kind]}" for kind in ("same", "failed", "differs"))
    answer(f"seed {seed}\nruns {count}, {counts}")
    raise SystemExit(found["same"] != count)


if __name__ == "__main__":
    start(main)

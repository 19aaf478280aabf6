"""Damage files and show what came of it: `python -m benchmarks.fuzz --count 100000 --seed 1`."""

from __future__ import annotations

from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.command import start
from benchmarks.fuzz.targets import TARGETS
from benchmarks.fuzz.worker import findings
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead

CHUNK = 1000
"""Inputs for one process."""


@dataclass
class Row:
    """What came of a target's inputs."""

    verdicts: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0
    megabytes: float = 0.0

    @property
    def failures(self) -> int:
        """How many inputs were neither taken nor refused in a sentence."""
        return self.verdicts.total() - self.verdicts["accepted"] - self.verdicts["refused"]


def main(
    count: Annotated[int, typer.Option(help="Inputs in all.")] = 100_000,
    seed: Annotated[int, typer.Option(help="The same seed gives the same inputs.")] = 1,
    only: Annotated[str | None, typer.Option(help="Targets, with commas between. Default: all.")] = None,
    jobs: Annotated[int, typer.Option(help="Processes that run at once.")] = 2,
    failing: Annotated[Path, typer.Option(help="Folder for inputs that fail.")] = Path("out/fuzz"),
) -> None:
    """Damage files, have them read, and say how often that went wrong; exit code 1 where it did."""
    chosen = list(TARGETS) if only is None else only.split(",")
    for name in chosen:
        if name not in TARGETS:
            raise InputError(f"--only {name}: no such target; {instead(name, TARGETS)}")
    if count < 1 or jobs < 1:
        raise InputError(f"--count {count} --jobs {jobs}: give numbers above 0")
    usual = count / sum(TARGETS[name].share for name in chosen)
    rows = {name: Row() for name in chosen}
    chunks = [
        (name, range(first, min(first + CHUNK, wanted)))
        for name in chosen
        for wanted in [max(1, round(usual * TARGETS[name].share))]
        for first in range(0, wanted, CHUNK)
    ]

    def try_all(name: str, numbers: range) -> None:
        row = rows[name]
        for finding in findings(name, seed, numbers, failing):
            row.verdicts[finding.verdict] += 1
            row.seconds = max(row.seconds, finding.seconds)
            row.megabytes = max(row.megabytes, finding.megabytes)

    with ThreadPoolExecutor(jobs) as pool:
        for each in [pool.submit(try_all, *chunk) for chunk in chunks]:
            each.result()
    _show(rows, seed, failing)
    raise SystemExit(any(row.failures for row in rows.values()))


def _show(rows: dict[str, Row], seed: int, failing: Path) -> None:
    heads = ("inputs", "refused", "accepted", "failed", "longest", "memory")
    print(f"seed {seed}\n{'':20}" + "".join(f"{head:>10}" for head in heads))
    for name, row in rows.items():
        found = row.verdicts
        print(
            f"{name:20}{found.total():10}{found['refused']:10}{found['accepted']:10}{row.failures:10}"
            f"{row.seconds:8.2f} s{row.megabytes:7.0f} MB"
        )
    for name, row in rows.items():
        for verdict, times in row.verdicts.most_common():
            if verdict not in ("accepted", "refused"):
                print(f"{name}: {times} x {verdict}")
    if any(row.failures for row in rows.values()):
        print(f"inputs that failed  {failing}")


if __name__ == "__main__":
    start(main)

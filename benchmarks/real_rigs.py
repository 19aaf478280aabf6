"""Held-out errors on strangers' rigs: what is delivered, the uncorrected model, and the plainest fits."""

from __future__ import annotations

import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

from benchmarks.command import start
from tests.real_rigs import RIGS
from warmlink.orchestration.console import answer, print_table
from warmlink.orchestration.diagnosis.answer.ladder import ladder_lines, table_of
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.report.diagnosis import write_diagnosis
from warmlink.orchestration.threads import one_thread


def main(
    only: Annotated[list[str] | None, typer.Option(help="Names of rigs that hold this text.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for the pages.")] = None,
) -> None:
    """Diagnose strangers' rigs and print the ladder of each; the measurements are not part of the project."""
    for name, rig in RIGS.items():
        if only and not any(each in name for each in only):
            continue
        with TemporaryDirectory() as folder:
            begun = time.process_time()
            found = diagnose_experiment(read([rig.write(Path(folder))]))
            with one_thread():
                headings, rows = table_of(found)
            took = time.process_time() - begun
        answer(f"{name}: {found.verdict}, {took:.1f} s of processor time")
        told = {channel.partition(" [")[0]: channel for channel, *_ in rows}
        stated = {told[c]: f"{error:g}" for c, error in rig.plain.items() if c in told}
        rows = [(*row, stated.get(row[0], "-")) for row in rows]
        print_table("", (*headings, "as stated"), rows, texts=1, width=160)
        answer("\n".join(ladder_lines(found)))
        if out is not None:
            write_diagnosis(found, out / name)


if __name__ == "__main__":
    start(main)

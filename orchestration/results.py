"""Folders of results: each holds those of one command line.

The same command line replaces its own. Another line of the same command, as `warmlink run --controller lag`
after `warmlink run`, moves the earlier results into a folder inside, `earlier-1`. Results of another command
are refused. Files that several commands write, as `report.html`, count as a command's own.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path

from warmlink.fmus.arguments import argument, command_given
from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import remark
from warmlink.orchestration.files import fresh_folder, settle
from warmlink.orchestration.text_files import is_file

ASKED = "command.txt"
"""File beside the results with the command line that made them."""

_WRITTEN = {
    "run": ("metrics.json", "results.csv", "results.parquet", "live.html", "report.html"),
    "simulate": ("results.csv", "results.parquet"),
    "compare": ("compare.csv", "logs.csv", "report.html"),
    "tune": ("trials.csv", "winner.ssv", "winner-*.ssv", "report.html"),
    "sweep": ("sweep.parquet", "report.html"),
    "diagnose": (
        *("diagnosis.json", "report.html", "extended.ssv", "extended.ssp"),
        *("next_experiment.toml", "next_experiment.csv"),
    ),
    "reproduce": ("report.html",),
}
RESULTS = {command: (*names, ASKED) for command, names in _WRITTEN.items()}
"""Files that each command writes as its results, a pattern for several; it may leave some out."""


def refuse_others(folder: Path, command: str) -> None:
    """Raise InputError if a folder holds results of another command."""
    settle(folder)
    own = results_in(folder, command)
    for other in RESULTS:
        for path in results_in(folder, other):
            if path not in own:
                raise InputError(
                    f"{folder}: holds {path.name} of warmlink {other}; choose another "
                    f"{argument('out')}, or remove that, so that results of two commands do not mix"
                )


def results_in(folder: Path, command: str) -> list[Path]:
    """Files in a folder that are results of a command; a name that no folder can have holds none."""
    with suppress(OSError, ValueError):
        return [path for name in RESULTS[command] for path in folder.glob(name) if is_file(path)]
    return []


def _earlier(folder: Path, command: str, asked: str) -> tuple[str, str]:
    """Folder inside for results of another command line, and that line; empty if there are none."""
    before = ""
    with suppress(OSError, ValueError):
        before = (folder / ASKED).read_text(encoding="utf-8").strip()
    if before == asked or not results_in(folder, command):
        return "", ""
    numbers = (f"earlier-{number}" for number in count(1))
    return next(name for name in numbers if not (folder / name).exists()), before


@contextmanager
def results_folder(folder: Path, command: str) -> Iterator[Path]:
    """A fresh folder for the results of a command.

    Results that the same command line wrote before go, and those of a program where a program calls; those
    of another command line are kept in a folder inside, as a remark says. Raises as `refuse_others` and
    `fresh_folder`.
    """
    refuse_others(folder, command)
    asked = command_given()
    kept_in, before = _earlier(folder, command, asked)

    with fresh_folder(folder, lambda: results_in(folder, command), kept_in) as work:
        if asked:  # at first, so that a full disk is told before anything is computed
            (work / ASKED).write_text(f"{asked}\n", encoding="utf-8")
        yield work
        written = any(path.name != ASKED for path in work.iterdir())
        if not written:
            (work / ASKED).unlink(missing_ok=True)
    if kept_in and written:
        of = f" (of {before})" if before else ""
        remark(f"the results that were in {folder}{of} are kept in {folder / kept_in}")

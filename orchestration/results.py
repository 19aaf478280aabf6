"""Folders of results: each holds those of one command, of one run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.files import fresh_folder, settle
from warmlink.orchestration.text_files import is_file

RESULTS = {
    "run": ("metrics.json", "results.csv", "results.parquet", "live.html", "report.html"),
    "simulate": ("results.csv", "results.parquet"),
    "compare": ("compare.csv", "report.html"),
    "tune": ("trials.csv", "winner.ssv", "winner-*.ssv", "report.html"),
    "sweep": ("sweep.parquet", "report.html"),
    "diagnose": (
        *("diagnosis.json", "report.html", "extended.ssv", "extended.ssp"),
        *("next_experiment.toml", "next_experiment.csv"),
    ),
    "reproduce": ("report.html",),
}
"""Files that each command writes as its results, a pattern for several; it may leave some out."""


def refuse_others(folder: Path, command: str) -> None:
    """Raise InputError where a folder holds results of another command, beside which its own would stand."""
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


@contextmanager
def results_folder(folder: Path, command: str) -> Iterator[Path]:
    """A fresh folder for the results of a command, before which go those that it wrote before.

    Raises as `refuse_others` and `fresh_folder`.
    """
    refuse_others(folder, command)
    with fresh_folder(folder, lambda: results_in(folder, command)) as work:
        yield work

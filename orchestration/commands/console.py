"""How commands speak: progress and remarks on standard error, answers on standard output."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


def answer(text: str) -> None:
    """Print an answer."""
    print(text)


def answer_json(value: Any) -> None:
    """Print an answer for machines."""
    print(json.dumps(value, indent=2, allow_nan=False))


def remark(text: str) -> None:
    """Say something beside the answer."""
    print(f"warmlink: {text}", file=sys.stderr)


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[float], None]]:
    """Progress bar on a terminal, nothing elsewhere; give it the share done, 0 to 1."""
    with noted_progress_bar(what) as show:
        yield lambda share: show(share, "")


@contextmanager
def noted_progress_bar(what: str) -> Iterator[Callable[[float, str], None]]:
    """Progress bar that also shows a note; give it the share done and the note."""
    if not sys.stderr.isatty():
        yield lambda share, note: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn(what),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}"),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=1.0, note="")
        yield lambda share, note: bar.update(task, completed=share, note=note)


@contextmanager
def spinner(what: str) -> Iterator[Callable[[str], None]]:
    """Spinner on a terminal, nothing elsewhere; give it what is being done."""
    if not sys.stderr.isatty():
        yield lambda doing: None
        return
    from rich.console import Console

    with Console(stderr=True).status(what) as status:
        yield lambda doing: status.update(f"{what}: {doing}")


def counted(progress: Callable[[float], None], total: int) -> Callable[[str], None]:
    """Turn a share of the work done into a call for each of `total` named parts."""
    done = 0

    def part(name: str) -> None:
        nonlocal done
        done += 1
        progress(done / total)

    return part

"""Progress: what is being done, how much of it is done, and how long the rest may take, on standard error."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from warmlink.fmus.safe_text import printable
from warmlink.orchestration.console import remark


class Progress(Protocol):
    """Takes what is being done, and which share of the whole is done if that is known, 0 to 1."""

    def __call__(self, doing: str, share: float | None = None, /) -> None:
        """Show it."""


def unseen(doing: str, share: float | None = None) -> None:
    """A progress that nobody watches."""


def stretch(progress: Progress, first: float, last: float) -> Progress:
    """Progress of a part of the work, which takes it from the first share to the last."""

    def show(doing: str, share: float | None = None, /) -> None:
        progress(doing, first + (last - first) * (share or 0.0))

    return show


_FIRST, _AGAIN = 20.0, 30.0
"""s after which a line of progress is printed where there is no terminal, and between two of them."""

_NOTEBOOK_AGAIN = 0.2
"""s between two lines of a notebook, each of which is written over the one before."""

_POLL = 1.0
"""s after which a line that is due is printed although nothing was done meanwhile."""

_no_lines = False


@contextmanager
def without_progress_lines() -> Iterator[None]:
    """Print no lines of progress meanwhile, as for another program that reads what a command prints."""
    global _no_lines
    before, _no_lines = _no_lines, True
    try:
        yield
    finally:
        _no_lines = before


def _lasting(seconds: float) -> str:
    """A time in words: `40 s`, `3 min`, `1 h 20 min`."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60:02} min"


class _Lines:
    """Lines that say what is done, where there is no terminal: in a notebook one, elsewhere a few."""

    def __init__(self, what: str) -> None:
        self._what, self._doing = what, ""
        self._share: float | None = None
        self._notebook, self._lock = "ipykernel" in sys.modules, threading.RLock()
        self._begun = time.monotonic()
        self._due = self._begun if self._notebook else self._begun + _FIRST
        self._silent = _no_lines and not self._notebook

    def show(self, doing: str, share: float | None = None) -> None:
        """Note what is done, and print it if it is time to."""
        with self._lock:
            self._doing, self._share = doing, share
            self.print_if_due()

    def print_if_due(self) -> None:
        """Print a line if the last one is long enough ago."""
        with self._lock:
            now = time.monotonic()
            if self._silent or now < self._due:
                return
            self._due = now + (_NOTEBOOK_AGAIN if self._notebook else _AGAIN)
            text = self._text(now - self._begun)
            if self._notebook:
                print(f"\r{printable(text):<79.79}", end="", file=sys.stderr, flush=True)
            else:
                remark(text)

    def clear(self) -> None:
        """Leave the line of a notebook empty."""
        if self._notebook:
            print(f"\r{'':79}\r", end="", file=sys.stderr, flush=True)

    def _text(self, elapsed: float) -> str:
        doing = ": ".join(filter(None, (self._what, self._doing)))
        if self._share is None:
            return f"{doing}; {_lasting(elapsed)} so far"
        share, left = min(max(self._share, 0.0), 1.0), ""
        if share > _TELLING and elapsed > 1.0:
            left = f", about {_lasting(elapsed * (1 - share) / share)} left"
        return f"{doing}; {100 * share:.0f} % in {_lasting(elapsed)}{left}"


_TELLING = 0.03
"""Share of the work from which on the time it took tells how long the rest will take."""


@contextmanager
def _lines(what: str) -> Iterator[Progress]:
    """Lines of progress, also while nothing is told for long."""
    shown, over = _Lines(what), threading.Event()

    def watch() -> None:
        while not over.wait(_POLL):
            shown.print_if_due()

    watching = threading.Thread(target=watch, name="progress", daemon=True)
    watching.start()
    try:
        yield shown.show
    finally:
        over.set()
        watching.join()
        shown.clear()


_under_way: Progress | None = None
"""The bar that is shown; whatever begins meanwhile counts as a part of it."""


@contextmanager
def spinner(what: str) -> Iterator[Progress]:
    """Progress on a terminal and in a notebook, elsewhere a line every 30 s once 20 s have passed.

    Give it what is being done, and which share of the whole is done if that is known: it then says how much
    time is left. Inside another one it is a part of that.
    """
    global _under_way
    outer, last = _under_way, None
    if outer is not None:
        outer(what)
        yield lambda doing, share=None: outer(": ".join(filter(None, (what, doing))))
        return
    with (_bar if sys.stderr.isatty() else _lines)(what) as drawn:

        def show(doing: str, share: float | None = None, /) -> None:
            nonlocal last
            last = last if share is None else share
            drawn(doing, last)

        _under_way = show
        try:
            yield show
        finally:
            _under_way = None


@contextmanager
def _bar(what: str) -> Iterator[Progress]:
    """Progress on a terminal."""
    from rich import progress as parts
    from rich.console import Console

    texts = (parts.TextColumn(f"{{task.{each}}}", markup=False) for each in ("description", "fields[doing]"))
    times = parts.TimeElapsedColumn(), parts.TimeRemainingColumn()
    columns = parts.SpinnerColumn(), *texts, parts.BarColumn(20), *times
    with parts.Progress(*columns, console=Console(stderr=True, emoji=False), transient=True) as bar:
        task = bar.add_task(printable(what), total=None, doing="")

        def update(doing: str, share: float | None = None, /) -> None:
            bar.update(task, total=None if share is None else 1.0, completed=share, doing=printable(doing))

        yield update


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[..., None]]:
    """Progress of what is counted; give it the share done, 0 to 1, and a note if there is one."""
    with spinner(what) as show:
        yield lambda share, note="": show(note, share)

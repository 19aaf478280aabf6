"""What commands print: progress and remarks on standard error, answers on standard output."""

from __future__ import annotations

import codecs
import io
import json
import sys
import threading
import time
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from itertools import count
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn, Protocol

from warmlink.fmus.safe_text import printable

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text

FAILED, BAD_INPUT, INTERRUPTED, TERMINATED = 1, 2, 130, 143
"""Exit codes: a run stopped early or a check failed; what was given cannot be used; Ctrl-C; SIGTERM."""

_PLAIN = {"µ": "u", "·": "-", "±": "+-", "°": "deg", "σ": "sigma", "→": "->", "–": "-", "…": "...", "•": "*"}
"""What is printed where a terminal's encoding lacks a character."""


class Terminated(KeyboardInterrupt):
    """The process was told to end (SIGTERM), as by docker stop, SLURM or systemd: the same as Ctrl-C."""


def end_as_interrupted(number: int, frame: FrameType | None) -> NoReturn:
    """Handler of SIGTERM in commands."""
    raise Terminated


def print_plainly() -> None:
    """Print on standard output and standard error what their encodings lack in other characters."""
    codecs.register_error("plainly", _plainly)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and not stream.encoding.lower().startswith("utf"):
            stream.reconfigure(errors="plainly")


def _plainly(fault: UnicodeError) -> tuple[str, int]:
    if not isinstance(fault, UnicodeEncodeError):
        raise fault
    lacking = fault.object[fault.start : fault.end]
    plain = (_PLAIN.get(each) or unicodedata.normalize("NFKD", each) for each in lacking)
    return "".join(text if text.isascii() else "?" for text in plain), fault.end


class Answer:
    """A result that prints a summary of itself, on a terminal and in a notebook."""

    def summary(self) -> str:
        """The result in a few lines."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return printable(self.summary())

    def _repr_html_(self) -> str:
        import html

        return f"<pre>{html.escape(printable(self.summary()))}</pre>"


def answer(text: str) -> None:
    """Print an answer."""
    print(printable(text))


def answer_json(value: Any) -> None:
    """Print an answer as JSON, for other programs."""
    print(json.dumps(value, indent=2, allow_nan=False))


def remark(text: str) -> None:
    """Print a remark, which is not part of the answer, on standard error."""
    print(f"warmlink: {printable(text)}", file=sys.stderr)


@cache
def remark_once(text: str) -> None:
    """Print a remark unless this process has done so."""
    remark(text)


def interrupted(fault: KeyboardInterrupt, told: str = "there are no results") -> SystemExit:
    """Say that Ctrl-C or SIGTERM came, and what of it; give what ends the process."""
    remark(f"interrupted; {told}")
    return SystemExit(TERMINATED if isinstance(fault, Terminated) else INTERRUPTED)


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


@contextmanager
def spinner(what: str) -> Iterator[Progress]:
    """Progress on a terminal and in a notebook, elsewhere a line every 30 s once 20 s have passed.

    Give it what is being done, and which share of the whole is done if that is known: it then says how much
    time is left.
    """
    if not sys.stderr.isatty():
        with _lines(what) as show:
            yield show
        return
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


def counted(progress: Callable[[float], None], total: int) -> Callable[[str], None]:
    """Turn a share of the work done into a call for each of `total` named parts."""
    done = count(1)
    return lambda name: progress(next(done) / total)


def print_table(
    title: str,
    headings: Sequence[str],
    rows: Iterable[Sequence[str | Text]],
    *,
    texts: int | None = None,
    width: int | None = None,
) -> None:
    """Print a table on standard output.

    Without headings the first of two columns stands out. So many columns `texts` hold text that is never
    broken; numbers follow, on the right of their columns. `width` is in characters, where standard output is
    no terminal; there is no edge to keep within in a file.
    """
    from rich.console import Console

    # Markup would take the unit in "speed [rad/s]" for a style.
    console = Console(markup=False, emoji=False)
    wide = console
    if not (console.is_terminal or width is None):
        wide = Console(width=width, markup=False, emoji=False)
    wide.print(_table(title, headings, rows, texts))
    if not headings:
        console.print()


def table_text(title: str, headings: Sequence[str], rows: Iterable[Sequence[str]], width: int = 160) -> str:
    """A table as text, at most so many characters wide."""
    from io import StringIO

    from rich.console import Console

    text = StringIO()
    Console(file=text, width=width, markup=False, emoji=False).print(_table(title, headings, rows, None))
    return text.getvalue().rstrip()


def _table(
    title: str, headings: Sequence[str], rows: Iterable[Sequence[str | Text]], texts: int | None
) -> Table:
    from rich.table import Table

    table = Table(title=printable(title), title_justify="left", box=None, show_header=bool(headings))
    for i, heading in enumerate(headings):
        is_text = texts is None or i < texts
        table.add_column(
            printable(heading), justify="left" if is_text else "right", no_wrap=bool(texts) and is_text
        )
    if not headings:
        table.title_style = "bold"
        table.add_column(style="cyan", no_wrap=True)
    for row in rows:
        table.add_row(*map(_printable_cell, row))
    return table


def _printable_cell(cell: str | Text) -> str | Text:
    """Give a cell of a table; styles of parts of it are lost where something in it had to be replaced."""
    if isinstance(cell, str):
        return printable(cell)
    plain = printable(cell.plain)
    return cell if plain == cell.plain else type(cell)(plain, cell.style)

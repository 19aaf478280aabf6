"""What commands print: remarks on standard error, answers on standard output."""

from __future__ import annotations

import codecs
import io
import json
import sys
import unicodedata
from collections.abc import Iterable, Sequence
from functools import cache
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn

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
    """Say that Ctrl-C or SIGTERM came and what happens now; give the exception that ends the process."""
    remark(f"interrupted; {told}")
    return SystemExit(TERMINATED if isinstance(fault, Terminated) else INTERRUPTED)


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

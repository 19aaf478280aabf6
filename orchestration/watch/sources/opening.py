"""The source of a name: a file, standard input, or an address."""

from __future__ import annotations

from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.orchestration.watch.sources.lines import LinesSource
from warmlink.orchestration.watch.sources.protocol import Source

STANDARD_INPUT = "-"


def opened(name: str, follow: bool, begin: int = 0) -> Source:
    """Open a source.

    Parameters
    ----------
    name : path of a log, or - for standard input
    follow : whether to wait for more at the end of a file
    begin : bytes of a file that were read before

    Raises
    ------
    InputError
        There is no such source, or it cannot be read.
    """
    scheme, there, _ = name.partition("://")
    if there:
        raise InputError(f"{name}: a source of {scheme} is not known; give a file, or - for standard input")
    return LinesSource(None if name == STANDARD_INPUT else Path(name), follow, begin)

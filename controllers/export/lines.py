"""Lines of a printed program."""

from __future__ import annotations

import re

WIDTH = 110
"""Characters of a line at most."""

_PIECE = re.compile(r"[^ (]*\(|[^ (]+(?: :=)? ?| ")
"""What is not divided: up to a space, or to what a bracket opens."""


def wrapped(text: str, indent: str) -> list[str]:
    """A statement on as many lines as it needs, those after the first one indented."""
    lines, line = [], ""
    for piece in _PIECE.findall(text):
        if line.strip() and len(line) + len(piece.rstrip()) > WIDTH:
            lines.append(line.rstrip())
            line = indent
        line += piece
    return [*lines, line.rstrip()]

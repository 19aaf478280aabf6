"""Commands that people are told to copy: nothing in them may run in the shell that they are pasted into."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path

_PLAIN = re.compile(r"[\w./-]+")
_QUOTABLE = re.compile(r'[^"$`\\!\x00-\x1f\x7f-\x9f]*')
"""What double quotes are enough for, in the shells of POSIX and of Windows."""


def command(*words: str | Path) -> str:
    """Command as its user's shell reads it, of words that may hold anything.

    A path does not look like an option.
    """
    return " ".join(map(quoted, words))


def quoted(word: str | Path) -> str:
    """One word of a command."""
    text = str(word)
    if isinstance(word, Path) and text.startswith("-"):
        text = f".{os.sep}{text}"
    if _PLAIN.fullmatch(text):
        return text
    if _QUOTABLE.fullmatch(text):
        return f'"{text}"'
    # Of cmd, which knows no other quotes.
    return f'"{text.replace(chr(34), 2 * chr(34))}"' if os.name == "nt" else shlex.quote(text)

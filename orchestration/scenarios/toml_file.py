"""TOML files that people write, read so that whatever is wrong with them ends in one sentence."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError


def is_file(path: Path) -> bool:
    """Whether there is such a file; a name that no file can have is that of none."""
    try:
        return path.is_file()
    except (OSError, ValueError):  # too long, or with a zero byte
        return False


def read_tables(path: Path) -> dict[str, Any]:
    """Content of a TOML file.

    Raises
    ------
    InputError
        If it cannot be read, or is no TOML.
    """
    try:
        return parse_tables(path.read_bytes(), path.name)
    except OSError as fault:
        raise InputError(f"{path}: cannot be read ({fault.strerror}); give a file that can") from None


def parse_tables(content: bytes, name: str) -> dict[str, Any]:
    """Tables of a TOML file's content; raises InputError if it is no TOML."""
    try:
        return tomllib.loads(content.decode("utf-8"))
    except RecursionError:
        raise InputError(f"{name}: not readable as TOML (nested too deep); mend the file") from None
    except ValueError as fault:  # no TOML, no UTF-8, a number of thousands of digits
        said = " ".join(str(fault).split())[:200]
        raise InputError(f"{name}: not readable as TOML ({said}); mend the file") from None


def text(value: Any, where: str) -> str:
    """A value that must be text; raises InputError otherwise."""
    if not isinstance(value, str):
        raise InputError(f"{where}: {value!r:.60} is no text; write it between quotation marks")
    return value

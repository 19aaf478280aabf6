"""Text from files, as names that strangers chose, made harmless for terminals, pages and spreadsheets."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas

# C0, DEL and C1; marks that turn the direction of writing; separators of lines; halves of characters.
_CONTROLS = r"\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ud800-\udfff"
_UNPRINTABLE = re.compile(f"[{_CONTROLS}]")
_IN_JSON = re.compile(r"(?<!\\)((?:\\\\)*)\\u([0-9a-fA-F]{4})")

_AT_A_FORMULA = re.compile(r"(^|[;\t\r\n])('*)(?=[=+\-@＝＋－＠])")
_AT_AN_APOSTROPHE = re.compile(r"(^|[;\t\r\n])'('*)(?=[=+\-@＝＋－＠])")


def printable(text: str) -> str:
    """Give text with codes in place of what steers a terminal or turns the direction of writing: `\\u202e`.

    Line breaks and tabs stay.
    """
    return _UNPRINTABLE.sub(lambda found: _code(found[0]), text)


def printable_json(text: str) -> str:
    """Give JSON whose strings are `printable`, be a character in it itself or as `\\u202e`."""

    def shown(found: re.Match[str]) -> str:
        character = chr(int(found[2], 16))
        # Halves of a pair are one harmless character.
        risky = _UNPRINTABLE.match(character) and not "\ud800" <= character <= "\udfff"
        return f"{found[1]}\\{_code(character)}" if risky else found[0]

    return _UNPRINTABLE.sub(lambda found: f"\\{_code(found[0])}", _IN_JSON.sub(shown, text))


def _code(character: str) -> str:
    """Give a character as `InputError` writes those that cannot be printed."""
    return ascii(character)[1:-1]


def as_cell(text: str) -> str:
    """Give text as a cell of a CSV file, with an apostrophe where a spreadsheet would find a formula.

    Those that split cells at semicolons find one after a semicolon, too. `of_cell` gives the text back.
    """
    return _AT_A_FORMULA.sub(r"\1'\2", text)


def of_cell(cell: str) -> str:
    """Give the text of a cell that `as_cell` made."""
    return _AT_AN_APOSTROPHE.sub(r"\1\2", cell)


def write_frame(frame: pandas.DataFrame, path: Path) -> None:
    """Write a table as CSV, in which a spreadsheet finds no formula."""
    held = frame.map(lambda value: as_cell(value) if isinstance(value, str) else value)
    held.rename(columns=as_cell).to_csv(path, index=False, lineterminator="\n")

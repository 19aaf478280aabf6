"""What is done to a good file: bytes flipped, pieces moved, values exchanged, one of them or several."""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from random import Random
from typing import Any

Mutator = Callable[[Random, bytes], bytes]
Way = tuple[Any, ...]
"""Keys and places that lead to an entry of a table within tables and lists."""

FRAGMENTS = (
    *("", "-1", "0", "1e999", "nan", "-inf", "1e-300", "9" * 30, "9" * 320, "0x12", "2,5", "true", "é", "µ"),
    *(
        "\u0000",
        "\ufffe",
        "\n",
        "\r",
        '"',
        "'",
        "#",
        ",",
        ";",
        "&amp;",
        "<x/>",
        "../",
        "/",
        "%s",
        "{}",
        "x" * 300,
    ),
    *("K", "W", "um", "mm", "1/0", "System", "Real", "Integer", "input", "output", "parameter", "ssd:"),
    *(
        'unit="',
        'name="',
        "resources/Link.fmu",
        "motor",
        "link.",
        "[[",
        "]]",
        "= ",
        "time [s]",
        "torque [N.m]",
    ),
)
WRONG: tuple[str, ...] = (
    *(
        "true",
        "-3",
        "0",
        "9" * 320,
        "2.5",
        "nan",
        "inf",
        "1e300",
        "1e-300",
        '""',
        '"x"',
        '"3 kg"',
        '"1e999 s"',
    ),
    *('"' + "x" * 300 + '"', '"a\\u0000b"', '"../x"', "[]", '["a"]', '[["a"]]', "[{}]", "[1, 2, 3]", "{}"),
    *("{ a = 1 }", "{ min = [] }", "2024-01-01", "2024-01-01T00:00:00Z", "03:00:00"),
)
"""Values in TOML, one of each type at the least."""

WRITTEN = (
    *((",", "\n", "utf-8"), (";", "\n", "utf-8"), ("\t", "\n", "utf-8"), (",", "\r\n", "utf-8-sig")),
    *((",", "\r", "utf-8"), (",", "\r\n", "utf-16"), (",", "\n", "latin-1"), (",", "\0", "utf-16-le")),
)
"""Separator, end of line and encoding with which programs write tables; the first is the usual."""


WORDS = (
    "OVERLOAD",
    "n/a",
    "ERR",
    "on",
    "Kim",
    "--",
    "1,2.3",
    "12:30",
    "2026-11-22",
    "3 kg",
    "²",
    "٣",
    "1e",
    "0x1F",
)
"""What stands where a number is due."""

HUGE = (
    "m" * 5000,
    "kg." * 1700,
    "(" * 5000,
    "1/" * 2500 + "s",
    "N.m" + "2" * 5000,
    "rad^" * 1250,
    "µ" * 5000,
)
"""Units of some 5000 characters."""

_UNIT = re.compile(r'(?<=\[)[^\]\n"]{0,40}(?=\])|(?<=unit=")[^"]*(?=")|(?<=\d )[A-Za-z][^"\s]*(?=")')
_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w.])")


class Raw:
    """A value as it stands in the file."""

    def __init__(self, text: str) -> None:
        self.text = text


def flipped(random: Random, content: bytes) -> bytes:
    """Change a few bytes, and perhaps cut off the end."""
    changed = bytearray(content)
    for _ in range(_few(random)):
        changed[random.randrange(len(changed))] = random.randrange(256)
    return bytes(changed[: random.randint(1, len(changed))] if random.random() < 0.2 else changed)


def spliced(random: Random, content: bytes) -> bytes:
    """Cut, exchange or double pieces of a text."""
    text = content.decode()
    for _ in range(_few(random)):
        start, length = random.randrange(len(text)), random.randint(0, 40)
        piece = text[start : start + length] * 2 if random.random() < 0.3 else random.choice(FRAGMENTS)
        text = text[:start] + piece + text[start + length :]
    return text.encode("utf-8", "surrogatepass")


def xml_values(random: Random, content: bytes) -> bytes:
    """Exchange values of attributes, so that the document stays well formed and later checks are reached."""
    parts = content.decode().split('"')
    for _ in range(_few(random)):
        place = 2 * random.randrange(len(parts) // 2) + 1
        fitting = [each for each in FRAGMENTS if not set(each) & {'"', "<", "\0"}]
        parts[place] = random.choice(parts[1::2] if random.random() < 0.5 else fitting)
    return '"'.join(parts).encode("utf-8", "surrogatepass")


def toml_values(random: Random, content: bytes) -> bytes:
    """Exchange, remove or add entries of the tables."""
    tree = tomllib.loads(content.decode())
    for _ in range(_few(random)):
        ways = list(ways_into(tree))
        if not ways:
            break
        way, kind = random.choice(ways), random.random()
        if kind < 0.7:
            tree = changed(tree, way, Raw(random.choice(WRONG)))
        elif kind < 0.85:
            tree = changed(tree, way, entry_at(tree, random.choice(ways)))
        else:
            tree = changed(tree, way, None)
    return toml(tree).encode()


def csv_cells(random: Random, content: bytes) -> bytes:
    """Exchange cells, move columns and rows, and write it as some other program would."""
    rows = [line.split(",") for line in content.decode().splitlines()]
    for _ in range(_few(random)):
        kind, row = random.randrange(6), random.choice(rows)
        place = random.randrange(len(row)) if row else 0
        if kind <= 2 and row:
            row[place] = random.choice((*FRAGMENTS, *rows[0], *row))
        elif kind == 3:
            row.append(random.choice(FRAGMENTS))
        elif kind == 4:
            for each in rows:  # a column goes, or stands twice
                del each[place : place + 1]
                each.extend(each[:1] * random.randint(0, 1))
        else:
            rows.insert(random.randrange(len(rows) + 1), rows.pop(random.randrange(len(rows))))
    separator, newline, encoding = random.choice((*WRITTEN, *[WRITTEN[0]] * 8))
    return newline.join(map(separator.join, rows)).encode(encoding, "replace")


def quoted(random: Random, content: bytes) -> bytes:
    """Open quotes before cells, and perhaps close them many rows later."""
    text = content.decode()
    for _ in range(random.choice((1, 1, 2, 3))):
        places = [found.end() for found in re.finditer(r"^|[,;\t\n]", text)]
        place = random.choice(places)
        text = text[:place] + '"' + text[place:]
    return text.encode()


def words(random: Random, content: bytes) -> bytes:
    """Write words where numbers stand: in one place, in several, or in all that look alike."""
    text = content.decode()
    found = list(_NUMBER.finditer(text))
    for each in sorted(random.sample(found, min(_few(random), len(found))), key=lambda f: -f.start()):
        text = text[: each.start()] + random.choice(WORDS) + text[each.end() :]
    return text.encode()


def word_columns(random: Random, content: bytes) -> bytes:
    """Write words into a stretch of a column, or into all of it."""
    rows = [line.split(",") for line in content.decode().splitlines()]
    first = random.randrange(1, len(rows)) if random.random() < 0.5 else 1
    last = random.randrange(first, len(rows)) + 1 if random.random() < 0.5 else len(rows)
    place, word = random.randrange(len(rows[0])), random.choice(WORDS)
    for row in rows[first:last]:
        if place < len(row):
            row[place] = random.choice(WORDS) if random.random() < 0.2 else word
    return "\n".join(map(",".join, rows)).encode()


def huge_units(random: Random, content: bytes) -> bytes:
    """Make some units thousands of characters long; where there is none, put one anywhere."""
    text = content.decode()
    found = list(_UNIT.finditer(text))
    if not found:
        place = random.randrange(len(text) + 1)
        return (text[:place] + random.choice(HUGE) + text[place:]).encode()
    for each in sorted(random.sample(found, min(_few(random), len(found))), key=lambda f: -f.start()):
        text = text[: each.start()] + random.choice(HUGE) + text[each.end() :]
    return text.encode()


def swapping(others: Callable[[], Mapping[str, bytes]]) -> Mutator:
    """Damage by pieces of other good files, in bytes or in whole lines."""

    def swapped(random: Random, content: bytes) -> bytes:
        for _ in range(_few(random)):
            other = others()[random.choice(sorted(others()))]
            if random.random() < 0.5:
                ours, theirs = content.splitlines(keepends=True), other.splitlines(keepends=True)
                at, start = random.randint(0, len(ours)), random.randrange(len(theirs))
                ours[at : at + random.randint(0, 4)] = theirs[start : start + random.randint(1, 6)]
                content = b"".join(ours)
            else:
                at, start = random.randint(0, len(content)), random.randrange(len(other))
                piece = other[start : start + random.randint(1, 400)]
                content = content[:at] + piece + content[at + random.choice((0, len(piece))) :]
        return content

    return swapped


def ways_into(tree: Any, way: Way = ()) -> Iterator[Way]:
    """Give the way to every entry, and to every element of a list."""
    if way:
        yield way
    for key in tree if isinstance(tree, dict) else range(len(tree)) if isinstance(tree, list) else ():
        yield from ways_into(tree[key], (*way, key))


def entry_at(tree: Any, way: Way) -> Any:
    """Give what a way leads to."""
    for key in way:
        tree = tree[key]
    return tree


def changed(tree: Any, way: Way, value: Any) -> Any:
    """Give a copy with another value at one place; None removes what is there."""
    whole = copy.deepcopy(tree)
    inner = entry_at(whole, way[:-1])
    if value is None:
        del inner[way[-1]]
    else:
        inner[way[-1]] = copy.deepcopy(value)
    return whole


def toml(tree: dict[str, Any]) -> str:
    """Write tables as TOML, an entry a line."""
    return "".join(f'"{key}" = {_inline(value)}\n' for key, value in tree.items())


def _inline(value: Any) -> str:
    if isinstance(value, Raw):
        return value.text
    if isinstance(value, dict):
        return "{ " + ", ".join(f'"{key}" = {_inline(each)}' for key, each in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_inline, value)) + "]"
    return f'"{value}"' if isinstance(value, str) else str(value).lower()


def lines(random: Random, content: bytes) -> bytes:
    """Remove, double or move whole lines."""
    rows = content.splitlines(keepends=True)
    for _ in range(_few(random)):
        start = random.randrange(len(rows))
        taken = rows[start : start + random.randint(1, 6)]
        if random.random() < 0.5:
            del rows[start : start + len(taken)]
        at = random.randint(0, len(rows))
        rows[at:at] = taken if random.random() < 0.7 else []
        rows = rows or [b"\n"]
    return b"".join(rows)


def _few(random: Random) -> int:
    """How many changes: mostly one, for several are refused for the first of them."""
    return random.choice((1, 1, 1, 1, 2, 3, 5))

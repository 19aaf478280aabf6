"""What is done to a good file: bytes flipped, pieces moved, values exchanged, one of them or several."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Callable, Iterator
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

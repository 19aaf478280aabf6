"""Keys of the files that come out, and columns of tables: what is said of each, beside an example."""

from __future__ import annotations

import csv
import json
import re
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

SAID = Path(__file__).parents[1] / "reference" / "results.toml"

HEADS = ("meaning", "type, unit", "where there is nothing to say", "example")


@cache
def said(name: str) -> dict[str, list[str]]:
    """What is said of each key, or column, of a file."""
    return tomllib.loads(SAID.read_text("utf-8"))[name]


def values(content: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Every value in what was read from JSON, with its key as `a.b[].c`."""
    if isinstance(content, dict):
        for name, each in content.items():
            yield from values(each, f"{key}.{name}" if key else name)
    elif isinstance(content, list | tuple):
        for each in content:
            yield from values(each, f"{key}[]")
    else:
        yield key, content


def entry_of(name: str, key: str) -> str | None:
    """The entry of a file's list that a key belongs to."""
    return next((entry for entry in said(name) if _is(entry, key)), None)


def _is(entry: str, key: str) -> bool:
    return re.fullmatch(re.escape(entry).replace(r"\*", ".+"), key) is not None


def undescribed(name: str, content: Any) -> list[str]:
    """Keys of a file's content of which nothing is said."""
    found = []
    for key, value in values(content):
        # A null may stand for a whole table.
        tables = {entry[: at.start()] for entry in said(name) for at in re.finditer(r"[.\[]", entry)}
        known = {*said(name), *(tables if value is None else ())}
        if not any(_is(entry, key) for entry in known):
            found.append(key)
    return found


def content_of(path: Path) -> dict[str, Any]:
    """What a JSON file holds; of a table, its columns with the first value of each."""
    if path.suffix == ".json":
        return json.loads(path.read_text("utf-8"))
    if path.suffix == ".parquet":
        from pyarrow import parquet

        return parquet.read_table(path).slice(0, 1).to_pylist()[0]
    with path.open(encoding="utf-8", newline="") as file:
        return next(csv.DictReader(file))


def rows(name: str, contents: list[dict[str, Any]]) -> tuple[list[tuple[str, ...]], list[str]]:
    """A row for each entry, with an example from the contents where none is given; and what has none."""
    examples: dict[str, Any] = {}
    for key, value in (each for content in contents for each in values(content)):
        if value not in (None, ""):
            examples.setdefault(entry_of(name, key) or key, value)
    found, missing = [], []
    for entry, (meaning, kind, unit, nothing, *given) in said(name).items():
        example = given[0] if given else examples.get(entry)
        if example is None:
            missing.append(entry)
        of = f"{kind}, {unit}" if unit else kind
        found.append((f"`{entry}`", meaning, of, nothing, f"`{shown(example)}`"))
    return found, missing


def shown(value: Any) -> str:
    """A value as an example."""
    if isinstance(value, float):
        return f"{value:.6g}"
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)

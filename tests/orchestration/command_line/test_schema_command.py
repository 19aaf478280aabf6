"""`warmlink schema`, and the schemas that the shipped files name."""

from __future__ import annotations

import json
import tomllib
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, get_args, get_type_hints

import pytest
from pydantic import TypeAdapter

from warmlink.fmus.errors import InputError
from warmlink.orchestration import catalogue
from warmlink.orchestration.closed_loop import load
from warmlink.orchestration.command_line.init import kinds, schema
from warmlink.orchestration.scenarios import mismatch
from warmlink.orchestration.scenarios.duties import duty_files
from warmlink.orchestration.studies import study
from warmlink.orchestration.text_files import read_toml
from warmlink.orchestration.written.tables import MEANINGS, json_schema, read_table

HOUSE = Path(catalogue.__file__).parent
FOLDERS = {
    "scenario": load.LIBRARY,
    "program": load.LIBRARY / "SixAxisArm",
    "duty": duty_files.LIBRARY,
    "study": study.LIBRARY,
    "mismatch": mismatch.LIBRARY,
}
SHIPPED = [(kind, path) for kind, folder in FOLDERS.items() for path in sorted(folder.glob("*.toml"))]


def printed(kind: str, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    schema(kind)
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


@pytest.mark.parametrize("kind", kinds())
def test_a_schema_lists_every_entry_of_its_file(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    found = printed(kind, capsys)
    assert set(found["properties"]) == {each.name for each in fields(kinds()[kind])}
    assert found["additionalProperties"] is False
    for entry in found["properties"].values():
        assert {"type", "$ref", "enum"} & set(entry)


@pytest.mark.parametrize("kind", kinds())
def test_the_shipped_schema_is_what_the_command_prints(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    shipped = json.loads((HOUSE / "schemas" / f"{kind}.json").read_text("utf-8"))
    assert shipped == printed(kind, capsys), (
        f"run: warmlink schema {kind} > orchestration/schemas/{kind}.json"
    )


@pytest.mark.parametrize(("kind", "path"), SHIPPED, ids=[path.stem for _, path in SHIPPED])
def test_a_shipped_file_names_its_schema_and_keeps_to_it(kind: str, path: Path) -> None:
    text = path.read_text("utf-8")
    directive, _, place = text.splitlines()[0].partition(" ")
    assert directive == "#:schema"
    assert (path.parent / place).resolve() == (HOUSE / "schemas" / f"{kind}.json").resolve()
    read_table(kinds()[kind], tomllib.loads(text), path.stem)


def test_an_unknown_kind_names_those_there_are() -> None:
    with pytest.raises(InputError, match=r"stduy: no such kind of file; did you mean study\?"):
        schema("stduy")


def tables(kind: type[Any]) -> dict[str, type[Any]]:
    """The classes that a file's tables are read into, by name."""
    found = {kind.__name__: kind}
    for hint in get_type_hints(kind).values():
        for inner in (hint, *get_args(hint)):
            if is_dataclass(inner) and isinstance(inner, type):
                found |= tables(inner)
    return found


@pytest.mark.parametrize("kind", kinds())
def test_every_entry_says_what_it_means_with_an_example_that_is_taken(kind: str) -> None:
    found = json_schema(kinds()[kind])
    classes = tables(kinds()[kind])
    assert set(classes) - {kinds()[kind].__name__} == set(found.get("$defs", ()))
    for name, table in {kinds()[kind].__name__: found, **found.get("$defs", {})}.items():
        hints = get_type_hints(classes[name], include_extras=True)
        for key, shape in table["properties"].items():
            assert shape.get("title"), f"{name}.{key}: say in schemas/meanings.toml what it means"
            for example in shape.get("examples", ()):
                TypeAdapter(hints.get(key) or hints["giver"]).validate_python(example)


def test_every_meaning_is_of_an_entry_that_there_is() -> None:
    known = {name: each for kind in kinds().values() for name, each in tables(kind).items()}
    entries = {name: set(json_schema(each)["properties"]) for name, each in known.items()}
    entries["any"] = {key for keys in entries.values() for key in keys}
    for name, meanings in read_toml(MEANINGS).items():
        assert set(meanings) <= entries[name], name

"""Files that people write (TOML), read into dataclasses; every mistake is reported in one sentence.

The annotations of such a dataclass, a table of the file, are `entries`, other tables, or lists (`tuple`) and
mappings of these; metadata `written` of a field says how it is called in the file, where that is no name in
Python. From these come the check, the conversion to SI units, the sentence for a mistake and the JSON Schema.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, Field, asdict, fields, is_dataclass
from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin, get_type_hints

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead, listed
from warmlink.orchestration.scenarios.entries import Entry
from warmlink.orchestration.text_files import read_toml, shortened, shown

MEANINGS = Path(__file__).parents[1] / "schemas" / "meanings.toml"

Table = TypeVar("Table")

Way = tuple[str | int, ...]
"""Name of the file, and what leads to a place in it: names of entries, and places in lists."""

Faults = list[tuple[bool, str]]
"""For each mistake whether its entry is a known one, and the sentence."""


def read_table(kind: type[Table], given: Any, name: str) -> Table:
    """Read the content of a file, as the TOML parser returns it, as a dataclass of a kind.

    InputError is raised if an entry is missing, unknown or wrong; the sentence says where, with the name of
    the file, its value, and the remedy.
    """
    faults: Faults = []
    read: Table = _read(kind, given, (name,), faults)
    if faults:
        # An unknown entry is reported before a missing one: it is often the missing one, misspelt.
        raise InputError(min(faults, key=lambda fault: fault[0])[1])
    return read


def _read(kind: Any, value: Any, way: Way, faults: Faults) -> Any:
    kind, told = _without_none(kind), ""
    try:
        if isinstance(kind, Entry):
            return kind._read(value)
        if is_dataclass(kind):
            return _read_fields(kind, value, way, faults)
    except InputError as fault:
        told = f": {fault}"
    inner = get_args(kind)
    if isinstance(value, list) and get_origin(kind) is tuple:
        return tuple(_read(inner[0], each, (*way, i), faults) for i, each in enumerate(value))
    if isinstance(value, Mapping) and get_origin(kind) is Mapping:
        return {key: _read(inner[1], each, (*way, key), faults) for key, each in value.items()}
    if not told:
        shape = _schema(kind, {})
        item = shape.get("items", {})
        told = f" is not a {'list of tables' if item else 'table'}; {_remedy(way[-1], shape)}"
        if "examples" in item:
            told = f": {shown(value)} is no list; write {way[-1]} = {_toml(item['examples'][:1])}"
    faults.append((True, f"{_place(way)}{told}"))
    return None


def _read_fields(kind: Any, value: Any, way: Way, faults: Faults) -> Any:
    known, given, before = _fields(kind), {}, len(faults)
    if not isinstance(value, Mapping):
        raise InputError(f"{shown(value)} is no table; give it {listed(sorted(known))}")
    for name, (each, inner) in known.items():
        if name in value:
            given[each.name] = _read(inner, value[name], (*way, name), faults)
        elif _required(each):
            remedy = _remedy(name, _table_schema(kind, {})["properties"][name])
            faults.append((True, f"{_place(way)}: {name} is missing; {remedy}"))
    for name in value:
        if name not in known:
            told = f"{shortened(name)} is not known; {instead(name, sorted(known))}"
            faults.append((False, f"{_place(way)}: {told}"))
    return kind(**given) if len(faults) == before else None


def json_schema(kind: type[Any]) -> dict[str, Any]:
    """JSON Schema of a table, with which editors complete and check a file."""
    about, others = (kind.__doc__ or "").partition("\n\n")[0], dict[str, Any]()
    found = {"description": about, **_table_schema(kind, others), **({"$defs": others} if others else {})}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **found}


def _schema(kind: Any, others: dict[str, Any]) -> dict[str, Any]:
    """Schema of what an annotation stands for; those of tables are added to the others."""
    kind = _without_none(kind)
    if isinstance(kind, Entry):
        return kind._schema()
    if is_dataclass(kind):
        name = kind.__name__  # type: ignore[union-attr]
        others[name] = _table_schema(kind, others)
        return {"$ref": f"#/$defs/{name}"}
    inner = _schema(get_args(kind)[-1 if get_origin(kind) is Mapping else 0], others)
    if get_origin(kind) is tuple:
        return {"type": "array", "items": inner}
    return {"type": "object", "additionalProperties": inner}


def _table_schema(kind: Any, others: dict[str, Any]) -> dict[str, Any]:
    meanings = {**_meanings()["any"], **_meanings().get(kind.__name__, {})}
    shapes: dict[str, Any] = {}
    for name, (each, inner) in _fields(kind).items():
        meaning = meanings.get(name, {})
        start = asdict(each.default) if is_dataclass(each.default) else each.default  # type: ignore[arg-type]
        default = {} if start in (MISSING, None) else {"default": start}
        told = {"title": meaning} if isinstance(meaning, str) else meaning
        shapes[name] = {**default, **_schema(inner, others), **told}
    required = [name for name, (each, _) in _fields(kind).items() if _required(each)]
    more = {"required": required} if required else {}
    return {"type": "object", "properties": shapes, **more, "additionalProperties": False}


@cache
def _meanings() -> dict[str, dict[str, Any]]:
    return read_toml(MEANINGS)


@cache
def _fields(kind: Any) -> dict[str, tuple[Field[Any], Any]]:
    """Fields of a table with their annotations, by what they are called in the file."""
    hints = get_type_hints(kind, include_extras=True)
    return {each.metadata.get("written", each.name): (each, hints[each.name]) for each in fields(kind)}


def _required(each: Field[Any]) -> bool:
    return each.default is MISSING and each.default_factory is MISSING


def _without_none(kind: Any) -> Any:
    """The entry, table, tuple or mapping that an annotation stands for, which may be left out."""
    if get_origin(kind) is Annotated:
        return kind.__metadata__[0]
    if get_origin(kind) in (Union, UnionType):
        return _without_none(next(each for each in get_args(kind) if each is not NoneType))
    return kind


def _remedy(name: str | int, shape: dict[str, Any]) -> str:
    """How an entry of a shape is written."""
    if "examples" in shape:
        return f"write {name} = {_toml(shape['examples'][0])}"
    return f"write [[{name}]] above each" if "items" in shape else f"write [{name}] above its entries"


def _place(way: Way) -> str:
    """Place in a file, as `mine: segment 1.duration`."""
    said = ""
    for step in way[1:]:
        if isinstance(step, int):
            said += f" {step + 1}"
        else:
            quoted = f'"{shortened(step)}"' if "." in step else shortened(step)
            said += f".{quoted}" if said else quoted
    return f"{way[0]}: {said}" if said else str(way[0])


def _toml(value: Any) -> str:
    """An example as it is written in a file."""
    if isinstance(value, list):
        return f"[{', '.join(_toml(each) for each in value)}]"
    return f'"{value}"' if isinstance(value, str) else str(value).lower()

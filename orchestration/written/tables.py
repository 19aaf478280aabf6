"""Files that people write (TOML), read by pydantic; all mistakes come at once, each in one sentence.

Each table of a file is a dataclass derived from `Table`, whose fields are annotated with classes of
`entries`. From these come the check, the conversion to SI units, the sentence for a mistake and the JSON
Schema. Results are cached on disk, so that pydantic is imported only for content not seen before.
"""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from warmlink.fmus.errors import refusal
from warmlink.fmus.names import instead, listed
from warmlink.fmus.packaging.cache import remembered
from warmlink.orchestration.text_files import read_toml, shortened, shown

MEANINGS = Path(__file__).parents[1] / "schemas" / "meanings.toml"
"""What each entry means, by the class of its table, for titles and examples in the JSON Schema."""


class Table:
    """A table of a file, in which an unknown entry is refused; its fields are annotated with `entries`."""

    __pydantic_config__: ClassVar[Any] = {"extra": "forbid"}


Read = TypeVar("Read")


def read_table(kind: type[Read], given: Any, name: str) -> Read:
    """Check parsed TOML and return it as an instance of the dataclass `kind`.

    InputError if entries are missing, unknown or wrong, with a sentence for each: the file by its `name`, the
    place in it, the value there, and the remedy.
    """
    asked = f"{kind.__module__}.{kind.__qualname__}", given
    return remembered("tables", asked, lambda: _checked(kind, given, name))


def _checked(kind: Any, given: Any, name: str) -> Any:
    from pydantic import ValidationError

    try:
        return _adapter(kind).validate_python(given)
    except ValidationError as refused:
        errors = refused.errors(include_url=False)
    # Unknown entries come first: one is often a missing one, misspelt, which is then not called missing.
    unknown = [error for error in errors if error["type"] == _UNKNOWN]
    others = [error for error in errors if error["type"] != _UNKNOWN and not _misspelt(error, unknown)]
    schema = json_schema(kind)
    raise refusal(_sentence(error, schema, name) for error in [*unknown, *others])


def _misspelt(error: Any, unknown: Sequence[Any]) -> bool:
    """Whether a missing entry seems to be there under a misspelt name, which is among the unknown ones."""
    if error["type"] != "missing":
        return False
    *table, key = error["loc"]
    beside = [each["loc"][-1] for each in unknown if [*each["loc"][:-1]] == table]
    return bool(get_close_matches(key, beside, cutoff=0.5))


@cache
def json_schema(kind: Any) -> dict[str, Any]:
    """JSON Schema of a table, with which editors complete and check a file; not to be changed."""
    about = (kind.__doc__ or "").partition("\n\n")[0]
    found: dict[str, Any] = _plain(_adapter(kind).json_schema())
    for name, table in ((kind.__name__, found), *found.get("$defs", {}).items()):
        for key, shape in table.get("properties", {}).items():
            meaning = {**_meanings()["any"], **_meanings().get(name, {})}.get(key, {})
            shape.update({"title": meaning} if isinstance(meaning, str) else meaning)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "description": about, **found}


@cache
def _meanings() -> dict[str, dict[str, Any]]:
    return read_toml(MEANINGS)


@cache
def _adapter(kind: Any) -> Any:
    from pydantic import TypeAdapter

    return TypeAdapter(kind)


def _plain(schema: Any) -> Any:
    """The schema without the null that TOML does not have, and without names and docstrings of classes."""
    if isinstance(schema, list):
        return [_plain(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    choice = [each for each in schema.get("anyOf", ()) if each != {"type": "null"}]
    kept = choice[0] if choice else schema
    noise: dict[str, type] = {"default": type(None), "title": str}
    if "properties" in kept:  # not all versions of pydantic give a dataclass's docstring
        noise["description"] = str
    return {k: _plain(v) for k, v in kept.items() if not (k in noise and isinstance(v, noise[k]))}


_UNKNOWN = "unexpected_keyword_argument"


def _sentence(error: Any, schema: dict[str, Any], name: str) -> str:
    """Sentence that says what is wrong, where, and the remedy, from one of pydantic's errors."""
    way, value, kind = error["loc"], error["input"], error["type"]
    if kind == _UNKNOWN:
        known = sorted(_at(schema, way[:-1]).get("properties", ()))
        key = shortened(way[-1])
        return f"{_place(name, way[:-1])}: {key} is not known; {instead(way[-1], known)}"
    place = _place(name, way)
    if kind == "value_error":
        return f"{place}: {error['ctx']['error']}"
    shape = _at(schema, way)
    if kind == "missing":
        given = f"write {way[-1]} = {_toml(shape['examples'][0])}" if "examples" in shape else ""
        return f"{_place(name, way[:-1])}: {way[-1]} is missing; {given or _heading(way, shape)}"
    if "properties" in shape:
        required, known = sorted(shape.get("required", ())), sorted(shape["properties"])
        entries = listed(required) if required else f"any of {listed(known)}"
        return f"{place}: {shown(value)} is not a table; write a table with {entries}"
    if "type" in shape.get("items", ()):
        example = _toml([shape["items"]["examples"][0]])
        return f"{place}: {shown(value)} is not a list; write {way[-1]} = {example}"
    what = "list of tables" if shape.get("type") == "array" else "table"
    return f"{place}: {shown(value)} is not a {what}; {_heading(way, shape)}"


def _heading(way: Sequence[str | int], shape: dict[str, Any]) -> str:
    if shape.get("type") == "array":
        return f"write [[{way[-1]}]] above each of them"
    return f"write [{way[-1]}] above its entries"


def _at(schema: dict[str, Any], way: Sequence[str | int]) -> dict[str, Any]:
    """The part of a schema at a path of table names."""
    shape = schema
    for step in (None, *way):
        if isinstance(step, int):
            shape = shape["items"]
        elif step is not None:
            shape = shape.get("properties", {}).get(step) or shape["additionalProperties"]
        if "$ref" in shape:
            shape = schema["$defs"][shape["$ref"].rpartition("/")[2]]
    return shape


def _place(name: str, way: Sequence[str | int]) -> str:
    """Name of a file with the place in it, as `mine: segment 1.duration`."""
    said = ""
    for step in way:
        if isinstance(step, int):
            said += f" {step + 1}"
        else:
            quoted = f'"{shortened(step)}"' if "." in step else shortened(step)
            said += f".{quoted}" if said else quoted
    return f"{name}: {said}" if said else name


def _toml(value: Any) -> str:
    """An example as it is written in a file."""
    if isinstance(value, list):
        return f"[{', '.join(_toml(each) for each in value)}]"
    return f'"{value}"' if isinstance(value, str) else str(value).lower()

"""Files that people write (TOML): what each entry may hold, and what is said where it holds something else.

The tables of a file are dataclasses that have `__pydantic_config__ = TABLE` and whose annotations are the
entries below, as `duration: Annotated[float, Quantity("s", positive=True)]`. From these come the check, the
conversion to SI units, the sentence for a mistake and the JSON Schema. Pydantic is imported when a file is
read, not before.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead, listed
from warmlink.orchestration.scenarios.quantity import in_si, not_positive
from warmlink.orchestration.text_files import shortened, shown

TABLE: Any = {"extra": "forbid"}
"""Pydantic's settings for a table: what it does not know is refused."""

Table = TypeVar("Table")


class Entry:
    """One entry of a file: how it is read, and its JSON Schema, whose first example shows how to write it."""

    def _read(self, value: Any) -> Any:
        """The value as the program has it; raises ValueError with what is wrong and the remedy."""
        raise NotImplementedError

    def _schema(self) -> dict[str, Any]:
        """JSON Schema of what may be written."""
        raise NotImplementedError

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        from pydantic_core import core_schema

        return core_schema.no_info_plain_validator_function(self._read)

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        return self._schema()


@dataclass(frozen=True)
class Text(Entry):
    """A text."""

    example: str = "..."

    def _read(self, value: Any) -> str:
        if not isinstance(value, str):
            raise InputError(f'{shown(value)} is no text; write "{self.example}"')
        return value

    def _schema(self) -> dict[str, Any]:
        return {"type": "string", "examples": [self.example]}


@dataclass(frozen=True)
class Flag(Entry):
    """True or false."""

    def _read(self, value: Any) -> bool:
        if not isinstance(value, bool):
            raise InputError(f"{shown(value)} is neither true nor false; write true or false")
        return value

    def _schema(self) -> dict[str, Any]:
        return {"type": "boolean", "examples": [True]}


@dataclass(frozen=True)
class Whole(Entry):
    """A whole number between two bounds, both included."""

    least: int
    most: int

    def _read(self, value: Any) -> int:
        whole = isinstance(value, int) and not isinstance(value, bool)
        if not whole or not self.least <= value <= self.most:
            raise InputError(f"{shown(value)} is no whole number from {self.least} to {self.most}; give one")
        return int(value)

    def _schema(self) -> dict[str, Any]:
        return {"type": "integer", "minimum": self.least, "maximum": self.most, "examples": [self.least]}


@dataclass(frozen=True)
class Number(Entry):
    """A finite number without a unit, called `what`, above one bound and at most the other."""

    what: str
    above: float = -math.inf
    at_most: float = math.inf

    def _read(self, value: Any) -> float:
        number = math.nan
        if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300:
            number = float(value)
        if not self.above < number <= self.at_most:
            bounds = "" if math.isinf(self.above) else f" above {self.above:g}, at most {self.at_most:g}"
            raise InputError(f"{shown(value)} is no {self.what}; give a number{bounds}")
        return number

    def _schema(self) -> dict[str, Any]:
        bounds = {"exclusiveMinimum": self.above, "maximum": self.at_most}
        known = {key: bound for key, bound in bounds.items() if math.isfinite(bound)}
        return {"type": "number", **known, "examples": [0.5]}


@dataclass(frozen=True)
class Quantity(Entry):
    """A value with a unit, as `"20 min"`, or a bare number in the SI unit."""

    unit: str
    positive: bool = False
    least: float = -math.inf

    def _read(self, value: Any) -> float:
        number = in_si(value, self.unit)
        if self.positive and number <= 0:
            raise InputError(not_positive(value, self.unit))
        if number < self.least:
            raise InputError(
                f"{number:g} {self.unit} is below {self.least:g} {self.unit}; give that or more"
                if self.least
                else f"{number:g} {self.unit} is negative; give 0 or above"
            )
        return number

    def _schema(self) -> dict[str, Any]:
        bound = (
            "above 0, " if self.positive else f"at least {self.least:g}, " if self.least > -math.inf else ""
        )
        return {
            "type": ["string", "number"],
            "description": f'{bound}as "3.5 {self.unit}", or a bare number in {self.unit}',
            "examples": [f"3.5 {self.unit}"],
        }


@dataclass(frozen=True)
class Bounds(Entry):
    """Two values with units, the lower one first."""

    unit: str
    least: float = 0.0

    def _read(self, value: Any) -> tuple[float, float]:
        if not isinstance(value, list) or len(value) != 2:
            raise InputError(f"{shown(value)} is no pair of bounds; give [lowest, highest]")
        low, high = (in_si(each, self.unit) for each in value)
        if not self.least <= low <= high:
            raise InputError(
                f"from {low:g} to {high:g} {self.unit} is no range; give bounds of at least "
                f"{self.least:g} {self.unit}, the lower first"
            )
        return low, high

    def _schema(self) -> dict[str, Any]:
        ends = Quantity(self.unit, least=self.least)._schema()
        example = [f"1 {self.unit}", f"2 {self.unit}"]
        return {"type": "array", "items": ends, "minItems": 2, "maxItems": 2, "examples": [example]}


@dataclass(frozen=True)
class Value(Entry):
    """A value of a variable, as it is written: the variable says of what unit it is."""

    def _read(self, value: Any) -> str | float:
        if isinstance(value, dict):
            inner = next(iter(value), "length")
            raise InputError(f'put the whole name in quotes, as "link.{shortened(inner)}" = "1 m"')
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise InputError(f'{shown(value)} is not a value; write a number with its unit, as "330 mm"')
        return value

    def _schema(self) -> dict[str, Any]:
        about = "A number with its unit, or a bare number in the SI unit of the variable"
        return {"type": ["string", "number"], "description": about, "examples": ["330 mm"]}


@dataclass(frozen=True)
class OneOf(Entry):
    """One of the names that there are."""

    names: Sequence[str]

    def _read(self, value: Any) -> str:
        if not isinstance(value, str) or value not in self.names:
            name = value if isinstance(value, str) else ""
            raise InputError(f"{shown(value)} is not known; {instead(name, self.names)}")
        return value

    def _schema(self) -> dict[str, Any]:
        return {"type": "string", "enum": list(self.names), "examples": [self.names[0]]}


@dataclass(frozen=True)
class Names(Entry):
    """A list of names, each of them once, and at least one."""

    example: str

    def _read(self, value: Any) -> tuple[str, ...]:
        if not isinstance(value, list) or not value or not all(isinstance(each, str) for each in value):
            raise InputError(f'is no list of names; write ["{self.example}"]')
        if len(set(value)) < len(value):
            raise InputError("names one twice; keep one")
        return tuple(value)

    def _schema(self) -> dict[str, Any]:
        items = {"type": "string"}
        example = [self.example]
        return {"type": "array", "items": items, "minItems": 1, "uniqueItems": True, "examples": [example]}


def read_table(kind: type[Table], given: Any, name: str) -> Table:
    """Content of a file as a table of a kind.

    Parameters
    ----------
    kind : dataclass
        With `__pydantic_config__ = TABLE` and entries as annotations.
    given : the tables as TOML has them
    name : of the file, put before a complaint

    Raises
    ------
    InputError
        An entry is missing, not known or cannot be used: where, its value, and the remedy.
    """
    from pydantic import ValidationError

    try:
        read: Table = _adapter(kind).validate_python(given)
        return read
    except ValidationError as refused:
        errors = refused.errors(include_url=False)
    # A misspelt entry explains a missing one.
    first = min(errors, key=lambda error: error["type"] != _UNKNOWN)
    raise InputError(_sentence(first, json_schema(kind), name))


def json_schema(kind: type[Any]) -> dict[str, Any]:
    """JSON Schema of a table, for editors that complete and check what is written."""
    found: dict[str, Any] = _plain(_adapter(kind).json_schema())
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **found}


_ADAPTERS: dict[Any, Any] = {}


def _adapter(kind: type[Any]) -> Any:
    from pydantic import TypeAdapter

    if kind not in _ADAPTERS:
        _ADAPTERS[kind] = TypeAdapter(kind)
    return _ADAPTERS[kind]


def _plain(schema: Any) -> Any:
    """The schema without the null that TOML does not have."""
    if isinstance(schema, list):
        return [_plain(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    choice = [each for each in schema.get("anyOf", ()) if each != {"type": "null"}]
    kept = choice[0] if choice else schema
    return {key: _plain(held) for key, held in kept.items() if not (key == "default" and held is None)}


_UNKNOWN = "unexpected_keyword_argument"


def _sentence(error: Any, schema: dict[str, Any], name: str) -> str:
    """What is wrong, where, and the remedy, from one of pydantic's errors."""
    way, value, kind = error["loc"], error["input"], error["type"]
    if kind == _UNKNOWN:
        known = sorted(_at(schema, way[:-1]).get("properties", ()))
        key = shortened(way[-1])
        return f"{_place(name, way[:-1])}: {key} is not known; {instead(way[-1], known)}"
    if kind == "missing":
        shape, key = _at(schema, way), way[-1]
        remedy = (
            f"write {key} = {_toml(shape['examples'][0])}" if "examples" in shape else _heading(way, shape)
        )
        return f"{_place(name, way[:-1])}: {key} is missing; {remedy}"
    place = _place(name, way)
    if kind == "value_error":
        return f"{place}: {error['ctx']['error']}"
    shape = _at(schema, way)
    if "properties" in shape:
        return f"{place}: {shown(value)} is no table; give it {listed(sorted(shape['properties']))}"
    if "type" in shape.get("items", ()):
        return (
            f"{place}: {shown(value)} is no list; write {way[-1]} = {_toml([shape['items']['examples'][0]])}"
        )
    what = "list of tables" if shape.get("type") == "array" else "table"
    return f"{place} is not a {what}; {_heading(way, shape)}"


def _heading(way: Sequence[str | int], shape: dict[str, Any]) -> str:
    if shape.get("type") == "array":
        return f"write [[{way[-1]}]] above each"
    return f"write [{way[-1]}] above its entries"


def _at(schema: dict[str, Any], way: Sequence[str | int]) -> dict[str, Any]:
    """The part of a schema that a way through the tables leads to."""
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
    """Where something stands, as `mine: segment 1.duration`."""
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

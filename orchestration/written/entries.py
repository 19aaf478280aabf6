"""The kinds of entries in files that people write (TOML).

A kind of entry says what it accepts, and how it refuses a wrong value. It is used as an annotation in the
dataclasses that `written` reads, for example `duration: Annotated[float, Quantity("s", positive=True)]`. An
entry refuses a value with an InputError that says what is wrong and the remedy; `written` puts the place in
the file before it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.text_files import shortened, shown
from warmlink.orchestration.written.quantities import not_positive, quantity, refuse_bare


class Setting:
    """One entry of a file: how it is read, and its JSON Schema, whose first example shows how to write it."""

    def _read(self, value: Any) -> Any:
        """Convert a value from the file; raise InputError with what is wrong and the remedy."""
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
class Text(Setting):
    """A text."""

    example: str = "..."

    def _read(self, value: Any) -> str:
        if not isinstance(value, str):
            raise InputError(f'{shown(value)} is no text; write "{self.example}"')
        return value

    def _schema(self) -> dict[str, Any]:
        return {"type": "string", "examples": [self.example]}


@dataclass(frozen=True)
class Flag(Setting):
    """True or false."""

    def _read(self, value: Any) -> bool:
        if not isinstance(value, bool):
            raise InputError(f"{shown(value)} is neither true nor false; write true or false")
        return value

    def _schema(self) -> dict[str, Any]:
        return {"type": "boolean", "examples": [True]}


@dataclass(frozen=True)
class Whole(Setting):
    """A whole number between two bounds, both included."""

    least: int
    most: int

    def _read(self, value: Any) -> int:
        whole = isinstance(value, int) and not isinstance(value, bool)
        if not whole or not self.least <= value <= self.most:
            raise InputError(
                f"{shown(value)} is not a whole number from {self.least} to {self.most}; give one"
            )
        return int(value)

    def _schema(self) -> dict[str, Any]:
        return {"type": "integer", "minimum": self.least, "maximum": self.most, "examples": [self.least]}


@dataclass(frozen=True)
class Number(Setting):
    """A finite number without a unit, called `what`, above one bound and at most the other."""

    what: str
    above: float = -math.inf
    at_most: float = math.inf

    def _read(self, value: Any) -> float:
        given = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300
        if not given or not self.above < value <= self.at_most:
            bounds = "" if math.isinf(self.above) else f" above {self.above:g}, at most {self.at_most:g}"
            raise InputError(f"{shown(value)} is no {self.what}; give a number{bounds}")
        return float(value)

    def _schema(self) -> dict[str, Any]:
        bounds = {"exclusiveMinimum": self.above, "maximum": self.at_most}
        known = {key: bound for key, bound in bounds.items() if math.isfinite(bound)}
        return {"type": "number", **known, "examples": [0.5]}


_WRITTEN = {
    **{"s": "20 min", "rad/s": "3.4 rad/s", "N.m": "2.5 N.m", "K": "22 degC", "K apart": "0.1 K"},
    **{"m": "330 mm", "rad": "30 deg", "W": "20 W", "1": "20 %"},
}
"""How a value is written, by its SI unit."""


@dataclass(frozen=True)
class Quantity(Setting):
    """A value with a unit, as `"20 min"`, or a bare number in the SI unit, except for lengths."""

    unit: str
    positive: bool = False
    least: float = -math.inf
    difference: bool = False

    def _read(self, value: Any) -> float:
        number, unit, least = quantity(value, self.unit, difference=self.difference), self.unit, self.least
        if not self.difference:
            refuse_bare(value, unit)
        if self.positive and number <= 0:
            raise InputError(not_positive(value, unit))
        if number < least:
            below = f"below {least:g} {unit}; give that or more" if least else "negative; give 0 or above"
            raise InputError(f"{number:g} {unit} is {below}")
        return number

    def _schema(self) -> dict[str, Any]:
        least = f"at least {self.least:g}, " if self.least > -math.inf else ""
        bare = "" if self.unit == "1" else f" in {self.unit}"
        about = f"{'above 0, ' if self.positive else least}with its unit"
        about += "" if self.unit == "m" else f", or a bare number{bare}"
        written = _WRITTEN[f"{self.unit} apart" if self.difference else self.unit]
        kinds = "string" if self.unit == "m" and self.positive else ["string", "number"]
        return {"type": kinds, "description": about, "examples": [written]}


@dataclass(frozen=True)
class Quantities(Setting):
    """So many values with units, as the speeds of six joints."""

    unit: str
    count: int
    least: float = -math.inf

    def _read(self, value: Any) -> tuple[float, ...]:
        count = self.count
        if not isinstance(value, list) or len(value) != count:
            raise InputError(f"{shown(value)} is no list of {count}; give {count} values with their units")
        numbers = tuple(quantity(each, self.unit) for each in value)
        for i, number in enumerate(numbers, start=1):
            refuse_bare(value[i - 1], self.unit)
            if number < self.least:
                raise InputError(f"value {i}: {number:g} {self.unit} is negative; give 0 or above")
        return numbers

    def _schema(self) -> dict[str, Any]:
        each = Quantity(self.unit, least=self.least)._schema()
        example = [f"{i} {self.unit}" for i in range(1, self.count + 1)]
        ends = {"minItems": self.count, "maxItems": self.count}
        return {"type": "array", "items": each, **ends, "examples": [example]}


@dataclass(frozen=True)
class Bounds(Quantities):
    """Two values with units, the lower one first."""

    count: int = 2
    least: float = 0.0

    def _read(self, value: Any) -> tuple[float, ...]:
        if not isinstance(value, list) or len(value) != 2:
            raise InputError(f"{shown(value)} is no pair of bounds; give [lowest, highest]")
        low, high = (quantity(each, self.unit) for each in value)
        if not self.least <= low <= high:
            raise InputError(
                f"from {low:g} to {high:g} {self.unit} is no range; give bounds of at least "
                f"{self.least:g} {self.unit}, the lower first"
            )
        return low, high


@dataclass(frozen=True)
class Value(Setting):
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


Values = Mapping[str, Annotated[str | float, Value()]]
"""Values as they are written, under `instance.variable`."""


@dataclass(frozen=True)
class OneOf(Setting):
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
class Names(Setting):
    """A list of names, each of them once, and at least one; or a single name where one will do."""

    example: str
    known: Sequence[str] = ()
    single: bool = False

    def _read(self, value: Any) -> tuple[str, ...]:
        listed = [value] if self.single and isinstance(value, str) else value
        if not isinstance(listed, list) or not listed or not all(isinstance(each, str) for each in listed):
            raise InputError(f'is no list of names; write ["{self.example}"]')
        for each in listed if self.known else ():
            if each not in self.known:
                raise InputError(f"{shown(each)} is not known; {instead(each, self.known)}")
        if len(set(listed)) < len(listed):
            raise InputError("names one twice; keep one")
        return tuple(listed)

    def _schema(self) -> dict[str, Any]:
        items = {"type": "string", **({"enum": list(self.known)} if self.known else {})}
        kinds = ["array", "string"] if self.single else "array"
        shape = {"type": kinds, "items": items, "minItems": 1, "uniqueItems": True}
        return {**shape, "examples": [[self.example]]}

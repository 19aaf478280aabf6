"""Variables of one base type, with the arrays that a call to an FMU takes, made once."""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import c_uint
from typing import Any

from warmlink.orchestration.system.model import Value


class Batch:
    """Variables of one base type among a set of variables, with the arrays a call needs.

    Parameters
    ----------
    base : str
        The type as the FMI functions name it: `Real`, `Float64` and so on.
    c_type : type
        Its ctypes type.

    Attributes
    ----------
    get, set : ctypes function
        Of the FMU.
    arguments : tuple
        Of both.
    """

    def __init__(self, base: str, c_type: Any, positions: list[int], references: list[int]) -> None:
        self.base = base
        self.positions = positions
        self.count = len(positions)
        self.plain = base in ("Real", "Float32", "Float64")
        self.references = (c_uint * self.count)(*references)
        self.values: Any = (c_type * self.count)()
        self.get: Any = None
        self.set: Any = None
        self.arguments: tuple[Any, ...] = ()

    def load(self, values: Sequence[Value]) -> None:
        """Fill the array from the values of the whole set."""
        chosen = values if self.count == len(values) else [values[p] for p in self.positions]
        if self.plain:
            self.values[:] = chosen
        elif self.base == "String":
            self.values[:] = [str(value).encode() for value in chosen]
        else:
            self.values[:] = [int(value) for value in chosen]

    def unload(self) -> list[Value]:
        """Give the array's values as Python values."""
        values: list[Value] = self.values[:]
        if self.base == "Boolean":
            return [bool(value) for value in values]
        if self.base == "String":
            return [(value or b"").decode("utf-8", "replace") for value in self.values]
        return values

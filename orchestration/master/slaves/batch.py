"""Variables of one base type, with the arrays that a call to an FMU takes, made once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from ctypes import c_uint
from itertools import accumulate
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.master.slaves.slave import Names
from warmlink.orchestration.system.model import Value, Variable

Held = dict[int, list[Value]]
"""All values of an array by its value reference: what its elements were set to, or start from."""

_FLOATS = ("Real", "Float32", "Float64")


def held_from_start(variables: Mapping[str, Variable]) -> Held:
    """Give the start values of everything, by value reference."""
    held: Held = {}
    for variable in variables.values():
        blank: Value = "" if variable.kind == "String" else 0
        values = held.setdefault(variable.value_reference, [blank] * variable.elements)
        if variable.start is not None:
            values[variable.element] = variable.start
    return held


class Batch:
    """Variables of one base type among a set of variables, with the arrays a call needs.

    `base` is the type as the FMI functions name it, `chosen` the variables by their places in the set, `held`
    the slave's values of arrays, of which some elements may be set alone. The FMU's functions `get` and `set`
    take the same `arguments`.
    """

    def __init__(self, base: str, c_type: Any, chosen: Mapping[int, Variable], held: Held) -> None:
        self.base, self.positions, self.count = base, list(chosen), len(chosen)
        self.arrays = any(variable.elements > 1 for variable in chosen.values())
        self.plain = base in _FLOATS and not self.arrays
        self._places = [(v.value_reference, v.element) for v in chosen.values()]
        self._held = held
        references, size = [reference for reference, _ in self._places], self.count
        if self.arrays:
            # FMI exchanges all elements of an array at once.
            sizes = {v.value_reference: v.elements for v in chosen.values()}
            starts = dict(zip(sizes, accumulate(sizes.values(), initial=0), strict=False))
            self._slots = [starts[reference] + element for reference, element in self._places]
            references, size = list(sizes), sum(sizes.values())
        self.references = (c_uint * len(references))(*references)
        self.values: Any = (c_type * size)()
        self.get: Any = None
        self.set: Any = None
        self.arguments: tuple[Any, ...] = ()

    def load(self, values: Sequence[Value]) -> None:
        """Fill the array from the values of the whole set."""
        chosen = values if self.count == len(values) else [values[p] for p in self.positions]
        if self.arrays:
            for (reference, element), value in zip(self._places, chosen, strict=True):
                self._held[reference][element] = value
            chosen = [value for reference in self.references for value in self._held[reference]]
        if self.base in _FLOATS:
            self.values[:] = chosen
        elif self.base == "String":
            self.values[:] = [str(value).encode() for value in chosen]
        else:
            self.values[:] = [int(value) for value in chosen]

    def unload(self) -> list[Value]:
        """Give the array's values as Python values."""
        values: list[Value] = self.values[:]
        if self.base == "Boolean":
            values = [bool(value) for value in values]
        if self.base == "String":
            values = [(value or b"").decode("utf-8", "replace") for value in self.values]
        return [values[slot] for slot in self._slots] if self.arrays else values


def sorted_by_type(
    slave: str,
    variables: Mapping[str, Variable],
    names: Names,
    base_type: Callable[[Variable], tuple[str, Any] | None],
    held: Held | None = None,
) -> list[Batch]:
    """Sort variables into batches of one base type; InputError where one is unknown or cannot be exchanged.

    `base_type` gives the name and ctypes type by which a variable is exchanged, or None where it cannot be;
    `held` keeps what arrays were set to.
    """
    found: dict[tuple[str, Any], dict[int, Variable]] = {}
    for position, name in enumerate(names):
        variable = variables.get(name)
        if variable is None:
            raise InputError(f"{slave}.{name}: the FMU has no such variable; {instead(name, variables)}")
        base = None if variable.dimensions else base_type(variable)
        if base is None:
            raise InputError(
                f"{slave}.{name}: {variable.type} values of this shape cannot be exchanged; "
                "choose a scalar number, Boolean or String"
            )
        found.setdefault(base, {})[position] = variable
    return [Batch(*base, chosen, held or {}) for base, chosen in found.items()]

"""Variables of one base type, with the arrays that a call to an FMU takes, made once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from ctypes import c_uint
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.master.slaves.slave import Names
from warmlink.orchestration.system.model import Value
from warmlink.orchestration.system.model_info import Variable


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


def sorted_by_type(
    slave: str,
    variables: Mapping[str, Variable],
    names: Names,
    base_type: Callable[[Variable], tuple[str, Any] | None],
) -> tuple[list[Batch], list[int] | None]:
    """Sort variables into batches of one base type; also their places among the values of all batches.

    The places are None where the variables follow in that order. `base_type` gives the name and ctypes type
    by which a variable is exchanged, or None where it cannot be.

    Raises
    ------
    InputError
        Where a variable is unknown or cannot be exchanged.
    """
    found: dict[str, tuple[Any, list[int], list[int]]] = {}
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
        _, positions, references = found.setdefault(base[0], (base[1], [], []))
        positions.append(position)
        references.append(variable.value_reference)
    batches = [Batch(base, *lists) for base, lists in found.items()]
    by_type = [position for batch in batches for position in batch.positions]
    places = sorted(range(len(names)), key=by_type.__getitem__)
    return batches, None if places == list(range(len(names))) else places

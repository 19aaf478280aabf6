"""How named variables lie in one flat vector, and are read from it by name."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

from warmlink.fmus.component.arithmetic import Number, stack
from warmlink.fmus.component.variables import Named

Record = Any
"""Named values, one attribute a variable: a number, or a vector where the variable has a size."""


class Layout:
    """How named variables lie in one flat vector.

    Names with dots, as `link.conductivity`, are read as records within records, so that the part of a joined
    component finds its own values as if it stood alone: `values.link.conductivity`.
    """

    def __init__(self, variables: Sequence[Named]) -> None:
        self.variables = tuple(variables)
        self.names = [name for variable in self.variables for name in variable.scalar_names]
        self.size = len(self.names)
        self.index = {name: i for i, name in enumerate(self.names)}
        self._places: dict[str, int | slice] = {}
        inner: dict[str, list[tuple[Named, slice]]] = {}
        start = 0
        for variable in self.variables:
            end = start + variable.count
            part, dot, rest = variable.name.partition(".")
            if dot:
                inner.setdefault(part, []).append((replace(variable, name=rest), slice(start, end)))
            else:
                self._places[variable.name] = start if variable.size is None else slice(start, end)
            start = end
        self._inner = {
            part: (Layout([v for v, _ in held]), _merged([place for _, place in held]))
            for part, held in inner.items()
        }
        plain = not inner and all(name.isidentifier() for name in self._places)
        self._record: Any = _record_type(list(self._places)) if plain else None

    def read(self, vector: Number) -> Record:
        """Named values of a flat vector of any arithmetic, shape (size,)."""
        if self._record is not None:
            return self._record._make([vector[place] for place in self._places.values()])
        values = {name: vector[place] for name, place in self._places.items()}
        values |= {part: layout.read(vector[place]) for part, (layout, place) in self._inner.items()}
        return SimpleNamespace(**values)

    def values(self, vector: Number) -> dict[str, Number]:
        """Values of a flat vector by the variables' names, shape (size,)."""
        found, start = {}, 0
        for variable in self.variables:
            end = start + variable.count
            found[variable.name] = vector[start] if variable.size is None else vector[start:end]
            start = end
        return found

    def record(self, values: Mapping[str, Number]) -> Record:
        """Record of named values, each a number or a vector, for a layout whose names have no dots."""
        return SimpleNamespace(**values) if self._record is None else self._record(**values)

    def flat(self, values: Mapping[str, Number]) -> Number:
        """Flat vector of named values, shape (size,).

        Raises
        ------
        KeyError
            A variable is missing, or one is named that is not declared.
        """
        if values.keys() != {v.name for v in self.variables}:
            missing = [v.name for v in self.variables if v.name not in values]
            unknown = [name for name in values if name not in {v.name for v in self.variables}]
            raise KeyError(f"missing: {missing}, not declared: {unknown}")
        return stack(*(values[v.name] for v in self.variables))


def _record_type(names: list[str]) -> Any:
    return namedtuple("Values", names)


def _merged(places: Sequence[slice]) -> slice | list[int]:
    """One place that holds several in their order: a slice where they adjoin."""
    if all(a.stop == b.start for a, b in pairwise(places)):
        return slice(places[0].start, places[-1].stop)
    return [i for place in places for i in range(place.start, place.stop)]

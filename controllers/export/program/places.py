"""Names that are free, tables of constants, and where in an array an element lies."""

from __future__ import annotations

import numpy as np

from warmlink.controllers.export.program.expressions import Array
from warmlink.controllers.export.program.statements import Index, Slot

_C = """auto break case char const continue default do double else enum extern float for goto if inline int
long register restrict return short signed sizeof static struct switch typedef union unsigned void
volatile while bool true false main nan infinity exp log sqrt fabs sin cos floor pow erf errno
signbit y0 y1 j0 j1 yn jn gamma isnan"""

_ST = """abs acos action add and any any_bit any_int any_num any_real array asin at atan bool by byte case
concat configuration constant cos ctd ctu ctud date delete dint div do dt dword else elsif
end_action end_array end_case end_configuration end_for end_function end_function_block end_if
end_program end_repeat end_resource end_step end_struct end_transition end_type end_var end_while en
eno eq exit exp expt f_edge f_trig false find for from function function_block ge gt if in
initial_step insert int interval le left len limit lint ln log lreal lt lword max mid min mod move
mul mux ne non_retain not of off on or priority program r r_edge r_trig real read_only read_write
repeat replace resource retain return right rol ror rs s sel shl shr sin single sint sqrt sr step
string struct sub tan task then time tod to tof ton tp transition true trunc type udint uint ulint
until usint var var_access var_config var_external var_global var_in_out var_input var_output
var_temp while with word wstring xor day char date_and_time time_of_day sema rtc integral derivative
pid ramp hysteresis val value_of size_of adr"""

RESERVED = frozenset(f"{_C} {_ST} i j k side".split())
"""Names that no variable of a law may have, in C or in Structured Text, in small letters."""


class FreeNames:
    """Names that are given once, whether letters are large or small.

    Parameters
    ----------
    taken : names that are not given
    also : a set that takes in every name that is given
    beside : another one's names, which may grow, and are not given either
    """

    def __init__(
        self, taken: set[str], also: set[str] | None = None, beside: FreeNames | None = None
    ) -> None:
        self._taken = set(taken) if also is not None else taken
        self._also, self._beside = also, beside
        self._given: set[str] = set()

    def fresh(self, name: str) -> str:
        """The name, with a number after it where it is taken."""
        made, count = name, 1
        while made.lower() in self._taken or (self._beside and made.lower() in self._beside._given):
            count += 1
            made = f"{name}_{count}"
        self._taken.add(made.lower())
        self._given.add(made.lower())
        if self._also is not None:
            self._also.add(made.lower())
        return made


class Tables:
    """Constants of a law that are no parameters: places of elements, vectors of known numbers."""

    def __init__(self, names: FreeNames) -> None:
        self.names, self._made = names, dict[tuple[bool, bytes], Slot]()

    def of(self, values: Array, name: str) -> Slot:
        """The constant array of these values."""
        whole = values.dtype.kind == "i"
        key = whole, values.tobytes()
        if key not in self._made:
            made = self.names.fresh(name)
            self._made[key] = Slot(made, (values.size,), "design", values=values.ravel(), whole=whole)
        return self._made[key]

    @property
    def all(self) -> list[Slot]:
        """Every one."""
        return list(self._made.values())


def fitted(places: Array, dims: tuple[str | int, ...], tables: Tables) -> Index:
    """Where in its source an element lies: linear in the loops where that is so, else by tables."""
    first = int(places.flat[0]) if places.size else 0
    parts, whole = [], np.full(places.shape, first)
    for axis in range(places.ndim):
        along = places[tuple(slice(None) if k == axis else 0 for k in range(places.ndim))] - first
        parts.append(along)
        whole = whole + along.reshape([-1 if k == axis else 1 for k in range(places.ndim)])
    if not np.array_equal(whole, places):
        table = tables.of(np.ascontiguousarray(places), "places")
        return Index(0, (), ((table, place_of(places.shape, dims)),))
    index = Index(first)
    for along, dim in zip(parts, dims, strict=True):
        index = _further(index, along, dim, tables)
    return index


def _further(index: Index, along: Array, dim: str | int, tables: Tables) -> Index:
    if isinstance(dim, int):
        return Index(index.constant + int(along[dim]), index.terms, index.tables)
    pace = int(along[1]) if along.size > 1 else 0
    if np.array_equal(along, pace * np.arange(along.size)):
        terms = (*index.terms, (dim, pace)) if pace else index.terms
        return Index(index.constant, terms, index.tables)
    lowest = int(along.min())  # places in a table are not below 0
    table = tables.of(np.ascontiguousarray(along - lowest), "places")
    read = (*index.tables, (table, Index(0, ((dim, 1),))))
    return Index(index.constant + lowest, index.terms, read)


def place_of(shape: tuple[int, ...], dims: tuple[str | int, ...]) -> Index:
    """Where an element lies in an array of a shape, element after element."""
    constant, terms, pace = 0, [], 1
    for count, dim in reversed(list(zip(shape, dims, strict=True))):
        if isinstance(dim, int):
            constant += pace * dim
        else:
            terms.append((dim, pace))
        pace *= count
    return Index(constant, tuple(reversed(terms)))

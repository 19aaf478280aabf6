"""Expressions that a law leaves behind when it is run with them: numbers and arrays.

There are few kinds. What NumPy does by indexing, slicing, transposing and packing is one of them, `take`: an
array of elements at places of another one. A product of matrices is a sum of products of two takes.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

LARGEST = 3e38
"""Beyond this a number is taken for not finite, in single precision too."""

FUNCTIONS: dict[str, Any] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "neg": np.negative,
    "abs": np.abs,
    "exp": np.exp,
    "log": np.log,
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
    "floor": np.floor,
    "pow": np.power,
    "lt": np.less,
    "le": np.less_equal,
    "gt": np.greater,
    "ge": np.greater_equal,
    "eq": np.equal,
    "and": np.logical_and,
    "or": np.logical_or,
    "not": np.logical_not,
    "select": np.where,
    "larger": lambda a, b: np.where(a > b, a, b),
    "smaller": lambda a, b: np.where(a < b, a, b),
    "erf": lambda a: np.vectorize(_erf)(a),
    "left": lambda a, b: b - ((a + b) - a),
}
"""What is done element by element."""

CONDITIONS = frozenset({"lt", "le", "gt", "ge", "eq", "and", "or", "not"})
"""Those whose result is true or false."""


def _erf(value: float) -> float:
    import math

    return math.erf(value)


@dataclass(eq=False)
class Computed:
    """A number or an array, and what it follows from.

    Attributes
    ----------
    kind : a key of `FUNCTIONS`, or `leaf`, `constant`, `take`, `stack`, `weave` (a stack in another order),
        `sum`, `result`
    of : expressions that it follows from
    shape : () for a number
    data : of a leaf its place, of a take the places, of a result the call and which of its results it is
    value : what it is where it follows from the design alone, else None
    origin : names of the parameters that such a value follows from
    name, fallback : of the variable that held it in the law, if any; of the argument that it was
    diagonal : of a diagonal matrix the vector on it
    rest : what rounding has left of it, where that is carried on
    """

    kind: str
    of: tuple[Computed, ...]
    shape: tuple[int, ...]
    data: Any = None
    value: Array | None = None
    origin: frozenset[str] = frozenset()
    name: str = ""
    fallback: str = ""
    serial: int = 0
    diagonal: Computed | None = None
    rest: Computed | None = None

    @property
    def size(self) -> int:
        """Number of elements."""
        return int(np.prod(self.shape, dtype=int))

    @property
    def ndim(self) -> int:
        """Number of dimensions."""
        return len(self.shape)

    @property
    def condition(self) -> bool:
        """Whether it is true or false."""
        return self.kind in CONDITIONS or (self.kind == "take" and self.of[0].condition)


remembered: dict[Any, Computed] = {}
"""Every expression so far, by what it is made of."""

_serial = itertools.count()

_class: type[Computed] = Computed
"""What expressions are made as: in the hands of a law they have operators."""


def begin(of: type[Computed]) -> None:
    """Begin anew, with no expression made yet; all are of this class from now on."""
    global _class
    _class = of
    remembered.clear()


def expression(kind: str, of: Iterable[Computed], shape: tuple[int, ...], data: Any = None) -> Computed:
    """An expression, which is made once."""
    of = tuple(of)
    told = (data.shape, data.tobytes()) if isinstance(data, np.ndarray) else data
    key = kind, tuple(map(id, of)), shape, told
    if key not in remembered:
        made = _class(kind, of, shape, data, serial=next(_serial))
        if of and kind != "result" and all(each.value is not None for each in of):
            made.value = worked_out(kind, of, data)
            made.origin = frozenset().union(*(each.origin for each in of))
        remembered[key] = made
    return remembered[key]


def worked_out(kind: str, of: tuple[Computed, ...], data: Any) -> Array:
    """What an expression is, if all that it is made of is known."""
    values = [np.asarray(each.value) for each in of]
    if kind == "take":
        return np.asarray(values[0].ravel()[data])
    if kind == "weave":
        return np.concatenate([np.atleast_1d(each) for each in values])[data]
    if kind == "stack":
        return np.concatenate([np.atleast_1d(each) for each in values])
    if kind == "sum":
        return np.asarray(values[0].sum(axis=-1))
    with np.errstate(all="ignore"):
        return np.asarray(FUNCTIONS[kind](*values))


def constant(value: Any) -> Computed:
    """A number or an array that is known, as far as single precision holds it."""
    array = np.clip(np.array(value, dtype=float), -LARGEST, LARGEST)
    made = expression("constant", (), array.shape, array)
    made.value = array
    return made


def lifted(value: Any) -> Computed:
    """A value as an expression."""
    return value if isinstance(value, Computed) else constant(value)


def is_number(one: Computed, value: Any) -> bool:
    """Whether all elements are a known number."""
    return one.kind == "constant" and bool(np.all(one.data == value))


class Given:
    """A record of a law: its states, inputs or parameters by name."""

    def __init__(self, values: dict[str, Computed]) -> None:
        self.__dict__.update(values)

    def __getitem__(self, name: str) -> Computed:
        found: Computed = self.__dict__[name]
        return found

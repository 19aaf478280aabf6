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

from warmlink.fmus.component.arithmetic import Traced
from warmlink.fmus.errors import InputError

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
class Noted(Traced):
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
    of: tuple[Noted, ...]
    shape: tuple[int, ...]
    data: Any = None
    value: Array | None = None
    origin: frozenset[str] = frozenset()
    name: str = ""
    fallback: str = ""
    serial: int = 0
    diagonal: Noted | None = None
    rest: Noted | None = None

    __array_priority__ = 1000.0

    @property
    def size(self) -> int:
        """Number of elements."""
        return int(np.prod(self.shape, dtype=int))

    @property
    def ndim(self) -> int:
        """Number of dimensions."""
        return len(self.shape)

    @property
    def real(self) -> Noted:
        """Itself: nothing is complex."""
        return self

    @property
    def T(self) -> Noted:  # noqa: N802 - NumPy's name
        """The transpose."""
        from warmlink.controllers.export.program.arrays import transposed

        return transposed(self)

    @property
    def condition(self) -> bool:
        """Whether it is true or false."""
        return self.kind in CONDITIONS or (self.kind == "take" and self.of[0].condition)

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Any:
        return (self[i] for i in range(self.shape[0]))

    def __bool__(self) -> bool:
        raise InputError("a law that is exported decides with where(condition, then, otherwise), not with if")

    def __float__(self) -> float:
        raise InputError(
            "a law that is exported computes with the functions of warmlink, as warmlink.exp, not with math's"
        )

    def __array_ufunc__(self, ufunc: Any, method: str, *given: Any, **more: Any) -> Any:
        from warmlink.controllers.export.program.algebra import apply, summed
        from warmlink.controllers.export.program.arrays import UFUNCS

        if method == "reduce" and ufunc is np.add:
            return summed(given[0])
        made = UFUNCS.get(ufunc.__name__)
        if method != "__call__" or made is None or more:
            raise InputError(f"numpy.{ufunc.__name__} in a law cannot be exported; use warmlink's functions")
        return made(*given) if callable(made) else apply(made, *given)

    def __array_function__(self, function: Any, types: Any, given: Any, more: Any) -> Any:
        from warmlink.controllers.export.program.arrays import ARRAYS

        if function.__name__ not in ARRAYS:
            raise InputError(
                f"numpy.{function.__name__} in a law cannot be exported; use warmlink's functions"
            )
        return ARRAYS[function.__name__](*given, **more)

    def __getitem__(self, key: Any) -> Noted:
        from warmlink.controllers.export.program.algebra import take

        return take(self, np.arange(self.size).reshape(self.shape)[key])

    def erf(self) -> Noted:
        """The error function of it."""
        from warmlink.controllers.export.program.algebra import apply

        return apply("erf", self)

    def accumulated(self, change: Any) -> Noted:
        """The sum with a change, and what rounding leaves of it if that is carried on."""
        from warmlink.controllers.export.program.algebra import accumulated

        return accumulated(self, change)

    def reshape(self, *shape: Any) -> Noted:
        """The same elements in another shape."""
        return self[...] if not shape else _reshaped(self, shape[0] if len(shape) == 1 else shape)

    def ravel(self) -> Noted:
        """The elements one after the other."""
        return _reshaped(self, -1)

    def sum(self) -> Noted:
        """The sum of the elements."""
        from warmlink.controllers.export.program.algebra import summed

        return summed(self)

    def whole(self, function: Any, given: tuple[Any, ...], idle: bool) -> Any:
        """A call of a function that stays a function."""
        from warmlink.controllers.export.program.tracing import call

        return call(function, given, idle)


remembered: dict[Any, Noted] = {}
"""Every expression so far, by what it is made of."""

_serial = itertools.count()


def forget() -> None:
    """Begin anew, with no expression made yet."""
    remembered.clear()


def expression(kind: str, of: Iterable[Noted], shape: tuple[int, ...], data: Any = None) -> Noted:
    """An expression, which is made once."""
    of = tuple(of)
    told = (data.shape, data.tobytes()) if isinstance(data, np.ndarray) else data
    key = kind, tuple(map(id, of)), shape, told
    if key not in remembered:
        made = Noted(kind, of, shape, data, serial=next(_serial))
        if of and kind != "result" and all(each.value is not None for each in of):
            made.value = worked_out(kind, of, data)
            made.origin = frozenset().union(*(each.origin for each in of))
        remembered[key] = made
    return remembered[key]


def worked_out(kind: str, of: tuple[Noted, ...], data: Any) -> Array:
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


def constant(value: Any) -> Noted:
    """A number or an array that is known, as far as single precision holds it."""
    array = np.clip(np.array(value, dtype=float), -LARGEST, LARGEST)
    made = expression("constant", (), array.shape, array)
    made.value = array
    return made


def lifted(value: Any) -> Noted:
    """A value as an expression."""
    return value if isinstance(value, Noted) else constant(value)


def is_number(one: Noted, value: Any) -> bool:
    """Whether all elements are a known number."""
    return one.kind == "constant" and bool(np.all(one.data == value))


def _reshaped(of: Noted, shape: Any) -> Noted:
    from warmlink.controllers.export.program.algebra import take

    return take(of, np.arange(of.size).reshape(shape))


def _operator(name: str, swapped: bool = False) -> Any:
    def method(self: Noted, *other: Any) -> Any:
        from warmlink.controllers.export.program.algebra import apply
        from warmlink.controllers.export.program.arrays import UFUNCS

        made = UFUNCS[name]
        given = (*other, self) if swapped else (self, *other)
        return made(*given) if callable(made) else apply(made, *given)

    return method


for _name, _ufunc in {
    "add": "add",
    "sub": "subtract",
    "mul": "multiply",
    "truediv": "divide",
    "pow": "power",
    "matmul": "matmul",
}.items():
    setattr(Noted, f"__{_name}__", _operator(_ufunc))
    setattr(Noted, f"__r{_name}__", _operator(_ufunc, swapped=True))
for _name, _ufunc in {
    "neg": "negative",
    "pos": "positive",
    "abs": "absolute",
    "lt": "less",
    "le": "less_equal",
    "gt": "greater",
    "ge": "greater_equal",
    "eq": "equal",
    "ne": "not_equal",
    "and": "logical_and",
    "or": "logical_or",
    "invert": "logical_not",
}.items():
    setattr(Noted, f"__{_name}__", _operator(_ufunc))
Noted.__hash__ = object.__hash__  # type: ignore[method-assign]


class Given:
    """A record of a law: its states, inputs or parameters by name."""

    def __init__(self, values: dict[str, Noted]) -> None:
        self.__dict__.update(values)

    def __getitem__(self, name: str) -> Noted:
        found: Noted = self.__dict__[name]
        return found

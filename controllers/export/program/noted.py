"""What a law computes with when it is written down: expressions with the operators of numbers and arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from warmlink.controllers.export.program.algebra import accumulated, apply, places_of, take
from warmlink.controllers.export.program.arrays import ARRAYS, UFUNCS, sum_along, transposed
from warmlink.controllers.export.program.expressions import Computed
from warmlink.controllers.export.program.tracing import call
from warmlink.fmus.component.arithmetic import Traced
from warmlink.fmus.errors import InputError

Operator = Callable[..., Any]


def _done(ufunc: str, *given: Any) -> Computed:
    """What a function of NumPy's does to expressions, element by element."""
    made = UFUNCS[ufunc]
    found: Computed = made(*given) if callable(made) else apply(made, *given)
    return found


def _operator(ufunc: str) -> Operator:
    return lambda *given: _done(ufunc, *given)


def _operators(ufunc: str) -> tuple[Operator, Operator]:
    """An operator with the expression on its left, and with it on its right."""
    return _operator(ufunc), lambda self, other: _done(ufunc, other, self)


def _refused(function: Any) -> InputError:
    return InputError(f"numpy.{function.__name__} in a law cannot be exported; use warmlink's functions")


def _array(function: Any, made: Operator, *given: Any, **more: Any) -> Any:
    """What a function of NumPy's does to arrays; InputError where it is asked for in a way not known here."""
    try:
        return made(*given, **more)
    except (TypeError, ValueError):
        raise _refused(function) from None


class Noted(Computed, Traced):
    """An expression that a law's Python takes for a number or an array of NumPy's."""

    __array_priority__ = 1000.0
    __hash__ = object.__hash__

    __add__, __radd__ = _operators("add")
    __sub__, __rsub__ = _operators("subtract")
    __mul__, __rmul__ = _operators("multiply")
    __truediv__, __rtruediv__ = _operators("divide")
    __pow__, __rpow__ = _operators("power")
    __matmul__, __rmatmul__ = _operators("matmul")
    __neg__, __pos__, __abs__ = map(_operator, ("negative", "positive", "absolute"))
    __lt__, __le__ = map(_operator, ("less", "less_equal"))
    __gt__, __ge__ = map(_operator, ("greater", "greater_equal"))
    __eq__, __ne__ = map(_operator, ("equal", "not_equal"))
    __and__, __or__, __invert__ = map(_operator, ("logical_and", "logical_or", "logical_not"))

    @property
    def real(self) -> Noted:
        """Itself: nothing is complex."""
        return self

    @property
    def T(self) -> Computed:  # noqa: N802 - NumPy's name
        """The transpose."""
        return transposed(self)

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[Computed]:
        return (self[i] for i in range(self.shape[0]))

    def __bool__(self) -> bool:
        raise InputError("a law that is exported decides with where(condition, then, otherwise), not with if")

    def __float__(self) -> float:
        raise InputError(
            "a law that is exported computes with the functions of warmlink, as warmlink.exp, not with math's"
        )

    def __array_ufunc__(self, ufunc: Any, method: str, *given: Any, **more: Any) -> Any:
        if method == "reduce" and ufunc is np.add:
            return _array(ufunc, sum_along, *given, **{"axis": 0, **more})
        if method != "__call__" or ufunc.__name__ not in UFUNCS or more:
            raise _refused(ufunc)
        return _done(ufunc.__name__, *given)

    def __array_function__(self, function: Any, types: Any, given: Any, more: Any) -> Any:
        if function.__name__ not in ARRAYS:
            raise _refused(function)
        return _array(function, ARRAYS[function.__name__], *given, **more)

    def __getitem__(self, key: Any) -> Any:
        return take(self, places_of(self)[key])

    def reshape(self, *shape: Any) -> Computed:
        """The same elements in another shape, given as numbers or as one tuple of them."""
        return take(self, places_of(self).reshape(*shape))

    def ravel(self) -> Computed:
        """The elements one after the other."""
        return self.reshape(-1)

    def sum(self, axis: int | None = None) -> Computed:
        """The sum of the elements, or along a dimension."""
        return sum_along(self, axis)

    def erf(self) -> Any:
        """The error function of it."""
        return apply("erf", self)

    def accumulated(self, change: Any) -> Any:
        """The sum with a change, and what rounding leaves of it if that is carried on."""
        return accumulated(self, change)

    def whole(self, function: Callable[..., Any], given: tuple[Any, ...], idle: bool) -> Any:
        """A call of a function that stays a function."""
        return call(function, given, idle)

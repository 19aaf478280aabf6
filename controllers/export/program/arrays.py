"""NumPy's functions of arrays and matrices, made of the few kinds of expressions that there are."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from warmlink.controllers.export.program.algebra import apply, places_of, stacked, summed, take
from warmlink.controllers.export.program.expressions import (
    LARGEST,
    Array,
    Computed,
    constant,
    expression,
    is_number,
    lifted,
)


def diagonal(of: Any) -> Computed:
    """Square matrix with a vector on its diagonal, or the diagonal of a matrix."""
    one = lifted(of)
    size = one.shape[0]
    if one.ndim == 2:
        return take(one, np.arange(size) * (size + 1))
    places = np.full((size, size), size)
    np.fill_diagonal(places, np.arange(size))
    made = expression("take", (expression("stack", (one, constant(0.0)), (size + 1,)),), (size, size), places)
    made.diagonal = one
    return made


def transposed(of: Computed) -> Computed:
    """The transpose of a matrix; a vector as it is."""
    if of.ndim < 2 or of.diagonal is not None:
        return of
    return take(of, places_of(of).T)


def product(a: Any, b: Any) -> Computed:
    """Product of matrices, or of a matrix and a vector."""
    a, b = lifted(a), lifted(b)
    if a.diagonal is not None:
        return apply("mul", a.diagonal if b.ndim == 1 else _column(a.diagonal), b)
    if b.diagonal is not None:
        return apply("mul", a, b.diagonal)
    rows, inner = (a.shape[0] if a.ndim == 2 else 1), a.shape[-1]
    columns = b.shape[1] if b.ndim == 2 else 1
    of_a, of_b = zeros(a).reshape(rows, inner), zeros(b).reshape(inner, columns)
    by_rows = _others(of_a)
    by_columns = _others(of_b.T)
    by_row = by_rows.shape[1] <= by_columns.shape[1]
    k = by_rows[:, None, :] if by_row else by_columns[None, :, :]
    i, j, _ = np.ogrid[:rows, :columns, : k.shape[2]]
    size = (rows, columns, k.shape[2])
    left = np.broadcast_to(i * inner + k, size)
    right = np.broadcast_to(k * columns + j, size)
    shape = (*([rows] if a.ndim == 2 else []), *([columns] if b.ndim == 2 else []))
    whole = (*shape, k.shape[2])
    return summed(apply("mul", take(a, left.reshape(whole)), take(b, right.reshape(whole))))


def zeros(one: Computed) -> Array:
    """Which elements are 0 whatever the numbers are, as those beside a diagonal."""
    if one.kind == "constant":
        return np.asarray(one.data == 0.0)
    if one.kind == "take":
        return np.asarray(zeros(one.of[0]).ravel()[one.data])
    if one.kind == "stack":
        return np.concatenate([np.atleast_1d(zeros(each)) for each in one.of])
    return np.zeros(one.shape, dtype=bool)


def _others(zero: Array) -> Array:
    """In each row the places of the elements that are not 0, filled up with others to the same number."""
    count = max(1, int((~zero).sum(axis=1).max(initial=0)))
    return np.sort(np.argsort(zero, axis=1, kind="stable")[:, :count], axis=1)


def outer(a: Any, b: Any) -> Computed:
    """Product of a column and a row."""
    row = lifted(b)
    return apply("mul", _column(lifted(a)), take(row, places_of(row)[None, :]))


def _column(of: Computed) -> Computed:
    return take(of, places_of(of)[:, None])


def blocks(rows: list[list[Any]]) -> Computed:
    """A matrix of matrices."""
    parts, places, start = [], [], 0
    for row in rows:
        of = []
        for part in map(lifted, row):
            parts.append(take(part, np.arange(part.size)))
            of.append(start + np.arange(part.size).reshape(part.shape))
            start += part.size
        places.append(of)
    return take(stacked(parts), np.block(places))


def joined(parts: Iterable[Any]) -> Computed:
    """Vectors, or matrices, below each other."""
    whole = [lifted(each) for each in parts]
    made = stacked(take(each, np.arange(each.size)) if each.ndim > 1 else each for each in whole)
    rows = whole[0].shape[1:]
    return take(made, places_of(made).reshape(-1, *rows)) if rows else made


def sum_along(of: Any, axis: int | None = None) -> Computed:
    """Sum along a dimension, or of all elements."""
    one = lifted(of)
    places = places_of(one)
    return summed(take(one, places.ravel() if axis is None else np.moveaxis(places, axis, -1)))


def power(base: Any, exponent: Any) -> Computed:
    """A power: of a known exponent of 1/2 or a small whole number the root or the product."""
    known = lifted(exponent)
    if is_number(known, 0.5):
        return apply("sqrt", base)
    if known.kind == "constant" and known.shape == () and float(known.data) in (1.0, 2.0, 3.0, 4.0):
        made = lifted(base)
        for _ in range(int(known.data) - 1):
            made = apply("mul", made, base)
        return made
    return apply("pow", base, exponent)


def finite(value: Any) -> Computed:
    """Whether a number is neither NaN nor infinite."""
    return apply("lt", apply("abs", value), LARGEST)


UFUNCS: dict[str, Any] = {
    "add": "add",
    "subtract": "sub",
    "multiply": "mul",
    "divide": "div",
    "negative": "neg",
    "positive": lifted,
    "absolute": "abs",
    "exp": "exp",
    "log": "log",
    "sqrt": "sqrt",
    "sin": "sin",
    "cos": "cos",
    "floor": "floor",
    "power": power,
    "less": "lt",
    "less_equal": "le",
    "greater": "gt",
    "greater_equal": "ge",
    "equal": "eq",
    "not_equal": lambda a, b: apply("not", apply("eq", a, b)),
    "logical_and": "and",
    "logical_or": "or",
    "logical_not": "not",
    "matmul": product,
    "isfinite": finite,
    "isnan": lambda a: apply("not", apply("eq", a, a)),
}
"""NumPy's functions of numbers: what they are called here, or the function that makes it."""

ARRAYS: dict[str, Any] = {
    "where": lambda condition, then, otherwise: apply("select", condition, then, otherwise),
    "sum": sum_along,
    "dot": product,
    "diag": diagonal,
    "outer": outer,
    "concatenate": joined,
    "column_stack": lambda parts: take(
        stacked(parts), np.arange(sum(lifted(p).size for p in parts)).reshape(len(parts), -1).T
    ),
    "block": blocks,
    "real": lifted,
    "ravel": lambda of: take(of, places_of(of).ravel()),
    "transpose": transposed,
}
"""NumPy's functions of arrays."""

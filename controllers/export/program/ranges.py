"""Between which bounds an expression lies, and whether it is a flag, as far as that follows from its form."""

from __future__ import annotations

from collections.abc import Callable
from math import exp, inf, isnan, sqrt

import numpy as np

from warmlink.controllers.export.program.algebra import told_by
from warmlink.controllers.export.program.expressions import Computed, is_number

Bounds = tuple[float, float]

SMALLEST = 1e-30
"""A number as small counts as 0: in single precision its square is."""


def never_zero(one: Computed) -> bool:
    """Whether an expression, NaN aside, cannot be 0."""
    low, high = bounds(one)
    return low > SMALLEST or high < -SMALLEST


def never_negative(one: Computed) -> bool:
    """Whether an expression, NaN aside, cannot be below 0."""
    return bounds(one)[0] >= 0.0


def bounds(one: Computed) -> Bounds:
    """Least and largest that an expression, NaN aside, can be."""
    if one.value is not None:
        return float(np.min(one.value)), float(np.max(one.value))
    of = [bounds(each) for each in one.of] if one.kind not in ("leaf", "result", "select") else []
    if one.kind == "select":
        a, b = bounds(one.of[1]), bounds(one.of[2])
        return min(a[0], b[0]), max(a[1], b[1])
    return _RULES[one.kind](one, *of) if one.kind in _RULES else (-inf, inf)


def _product(one: Computed, a: Bounds, b: Bounds) -> Bounds:
    if one.of[0] is one.of[1]:
        ends = [x * x for x in a]
        return (0.0 if a[0] <= 0.0 <= a[1] else min(ends)), max(ends)
    ends = [0.0 if isnan(x * y) else x * y for x in a for y in b]
    return min(ends), max(ends)


def _ratio(one: Computed, a: Bounds, b: Bounds) -> Bounds:
    if b[0] > 0.0:
        return (0.0 if a[0] >= 0.0 else -inf), (0.0 if a[1] <= 0.0 else inf)
    return -inf, inf


def _exponential(one: Computed, a: Bounds) -> Bounds:
    return (exp(a[0]) if a[0] > -700.0 else 0.0), (exp(a[1]) if a[1] < 700.0 else inf)


def _root(one: Computed, a: Bounds) -> Bounds:
    return sqrt(max(a[0], 0.0)), sqrt(max(a[1], 0.0))


def _several(one: Computed, *parts: Bounds) -> Bounds:
    return min(low for low, _ in parts), max(high for _, high in parts)


def _sum(one: Computed, a: Bounds) -> Bounds:
    count = one.of[0].shape[-1]
    return count * a[0], count * a[1]


_RULES: dict[str, Callable[..., Bounds]] = {
    "add": lambda one, a, b: (a[0] + b[0], a[1] + b[1]),
    "sub": lambda one, a, b: (a[0] - b[1], a[1] - b[0]),
    "mul": _product,
    "div": _ratio,
    "neg": lambda one, a: (-a[1], -a[0]),
    "abs": lambda one, a: (max(a[0], -a[1], 0.0), max(abs(a[0]), abs(a[1]))),
    "larger": lambda one, a, b: (max(a[0], b[0]), max(a[1], b[1])),
    "smaller": lambda one, a, b: (min(a[0], b[0]), min(a[1], b[1])),
    "exp": _exponential,
    "sqrt": _root,
    "erf": lambda one, a: (-1.0, 1.0),
    "take": lambda one, a: a,
    "stack": _several,
    "weave": _several,
    "sum": _sum,
}


def is_binary(one: Computed) -> bool:
    """Whether each element is 0 or 1, as far as that follows from its form."""
    if told_by(one) is not None or (one.kind == "constant" and bool(np.isin(one.data, (0.0, 1.0)).all())):
        return True
    if one.kind == "result":
        call, place = one.data
        return is_binary(call.function.results[place])
    if one.kind == "sub" and is_number(one.of[0], 1.0):
        return is_binary(one.of[1])
    of = one.of[1:] if one.kind == "select" else one.of
    return one.kind in _OF_BINARY and all(map(is_binary, of))


_OF_BINARY = frozenset({"larger", "smaller", "mul", "take", "stack", "select"})
"""What is 0 or 1 if all that it is made of is."""

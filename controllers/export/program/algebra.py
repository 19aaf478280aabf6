"""How expressions are made of expressions: simplified where no number changes, and each only once."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import Any

import numpy as np

from warmlink.controllers.export.program.expressions import (
    CONDITIONS,
    FUNCTIONS,
    LARGEST,
    SETTLED_ONCE,
    Array,
    Noted,
)

_made: dict[Any, Noted] = {}
_serial = itertools.count()


def forget() -> None:
    """Begin anew, with no expression made yet."""
    _made.clear()


def expression(kind: str, of: Iterable[Noted], shape: tuple[int, ...], data: Any = None) -> Noted:
    """An expression, which is made once."""
    of = tuple(of)
    told = (data.shape, data.tobytes()) if isinstance(data, np.ndarray) else data
    key = kind, tuple(map(id, of)), shape, told
    if key not in _made:
        made = Noted(kind, of, shape, data, serial=next(_serial))
        if of and kind != "result" and all(each.value is not None for each in of):
            made.value = _value(kind, of, data)
            made.origin = frozenset().union(*(each.origin for each in of))
        _made[key] = made
    return _made[key]


def _value(kind: str, of: tuple[Noted, ...], data: Any) -> Array:
    values = [np.asarray(each.value) for each in of]
    if kind == "take":
        return np.asarray(values[0].ravel()[data])
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


def apply(kind: str, *given: Any) -> Noted:
    """A function of expressions, element by element."""
    of = [lifted(each) for each in given]
    shape = np.broadcast_shapes(*(each.shape for each in of))
    if kind not in ("and", "or", "not"):
        first = 1 if kind == "select" else 0
        of[first:] = [flag(each) if each.condition else each for each in of[first:]]
    if kind == "select" and not of[0].condition and of[0].kind != "constant":
        of[0] = told_by(of[0]) or apply("not", apply("eq", of[0], 0.0))
    of = [each if each.shape in ((), shape) else _broadcast(each, shape) for each in of]
    if all(each.kind == "constant" for each in of):
        found = _value(kind, tuple(of), None)
        return constant(found) if kind not in CONDITIONS else _known(bool(found.all()), shape)
    simple = _simplified(kind, of, shape)
    if simple is not None:
        return simple
    made = expression(kind, of, shape)
    if kind in SETTLED_ONCE and made.value is not None:
        made.kind, made.of, made.data = "leaf", (), ("settled", made.serial)
    return made


def hold(one: Noted) -> None:
    """Take for granted that a number is above 0."""
    key = "gt", (id(one), id(constant(0.0))), (), None
    _made[key] = _known(True, ())


def _known(truth: bool, shape: tuple[int, ...]) -> Noted:
    return constant(np.full(shape, float(truth)))


def _broadcast(one: Noted, shape: tuple[int, ...]) -> Noted:
    return take(one, np.broadcast_to(np.arange(one.size).reshape(one.shape), shape))


def flag(condition: Noted) -> Noted:
    """1 where a condition holds, else 0."""
    return expression("select", (condition, constant(1.0), constant(0.0)), condition.shape)


def told_by(one: Noted) -> Noted | None:
    """The condition that a flag tells of, or None where it is no flag."""
    if one.kind == "select" and is_number(one.of[1], 1.0) and is_number(one.of[2], 0.0):
        return one.of[0]
    return one if one.condition else None


def _simplified(kind: str, of: list[Noted], shape: tuple[int, ...]) -> Noted | None:
    a, b = (*of, *of)[:2]
    wide = [k for k in range(len(of)) if of[k].shape == shape]
    if kind == "add" and is_number(a, 0.0) and 1 in wide:
        return b
    if kind in ("add", "sub") and is_number(b, 0.0) and 0 in wide:
        return a
    if kind == "sub" and is_number(a, 0.0):
        return apply("neg", b)
    if kind == "mul" and (is_number(a, 0.0) or is_number(b, 0.0)):
        return constant(np.zeros(shape))
    if kind == "mul" and is_number(a, 1.0) and 1 in wide:
        return b
    if kind in ("mul", "div") and is_number(b, 1.0) and 0 in wide:
        return a
    if kind == "neg" and a.kind == "neg":
        return a.of[0]
    if kind == "not" and a.kind == "not":
        return a.of[0]
    if kind in ("and", "or"):
        for one, other in ((a, b), (b, a)):
            if one.kind == "constant" and one.shape == ():
                return other if bool(one.data) is (kind == "and") else _known(kind == "or", shape)
    if kind == "select":
        return _selected(of[0], of[1], of[2], shape)
    return _of_flags(kind, of, shape)


def _of_flags(kind: str, of: list[Noted], shape: tuple[int, ...]) -> Noted | None:
    """What is told by flags alone, as logic."""
    a, b = (*of, *of)[:2]
    if kind == "sub" and is_number(a, 1.0) and told_by(b) is not None and b.shape == shape:
        return flag(apply("not", told_by(b)))
    both = told_by(a), told_by(b)
    logic = {"mul": "and", "smaller": "and", "larger": "or"}.get(kind)
    if len(of) == 2 and logic and both[0] is not None and both[1] is not None:
        return flag(apply(logic, *both))
    if kind in ("lt", "le", "gt", "ge") and both[0] is not None and b.kind == "constant" and b.shape == ():
        one, zero = (bool(FUNCTIONS[kind](value, b.data)) for value in (1.0, 0.0))
        if one != zero:
            return both[0] if one else apply("not", both[0])
    return None


def _selected(condition: Noted, then: Noted, otherwise: Noted, shape: tuple[int, ...]) -> Noted | None:
    if condition.kind == "constant" and condition.shape == ():
        return _wide(then if condition.data else otherwise, shape)
    if then is otherwise or (then.kind == otherwise.kind == "constant" and is_number(then, otherwise.data)):
        return _wide(then, shape)
    if is_number(then, 0.0) and is_number(otherwise, 1.0) and condition.shape == shape:
        return flag(apply("not", condition))
    if condition.kind == "not" and told_by(then) is None:
        return apply("select", condition.of[0], otherwise, then)
    if condition.kind == "gt" and _same(condition.of, then, otherwise):
        return apply("larger", then, otherwise)
    if condition.kind == "lt" and _same(condition.of, then, otherwise):
        return apply("smaller", then, otherwise)
    if condition.kind == "lt" and _same(condition.of, otherwise, then):
        return apply("larger", then, otherwise)
    if condition.kind == "gt" and _same(condition.of, otherwise, then):
        return apply("smaller", then, otherwise)
    if condition.kind == "lt" and then.kind == "neg" and then.of[0] is otherwise is condition.of[0]:
        return apply("abs", otherwise)
    flags = told_by(then), told_by(otherwise)
    for here, other, of, logic in (
        (otherwise, 0.0, flags[0], ("and", condition)),
        (then, 1.0, flags[1], ("or", condition)),
        (then, 0.0, flags[1], ("and", apply("not", condition))),
        (otherwise, 1.0, flags[0], ("or", apply("not", condition))),
    ):
        if is_number(here, other) and of is not None:
            return flag(apply(logic[0], logic[1], of))
    return None


def _same(of: tuple[Noted, ...], *others: Noted) -> bool:
    return all(a is b for a, b in zip(of, others, strict=True))


def _wide(one: Noted, shape: tuple[int, ...]) -> Noted:
    return one if one.shape == shape else _broadcast(one, shape)


def take(of: Noted, places: Any) -> Noted:
    """Elements at places of the elements of another expression, shape as the places'."""
    places = np.asarray(places, dtype=int)
    if of.kind == "constant":
        return constant(of.data.ravel()[places])
    if places.shape == of.shape and np.array_equal(places.ravel(), np.arange(of.size)):
        return of
    if of.kind == "take":
        return take(of.of[0], of.data.ravel()[places])
    if of.kind == "select" and told_by(of) is not None and places.shape == ():
        return flag(take(of.of[0], places))
    if of.kind == "stack" and places.size:
        start = 0
        for part in of.of:
            if places.min() >= start and places.max() < start + part.size:
                return take(part, places - start)
            start += part.size
    if of.ndim >= 2 and of.kind in _MOVABLE and np.unique(places).size == places.size:
        return _inside(of, places)
    return _plain(of, places)


_MOVABLE = frozenset({"add", "sub", "mul", "sum", "neg"})
"""What may as well be done after elements of a matrix were taken, as those of its upper triangle."""


def _inside(of: Noted, places: Array) -> Noted:
    """Elements of a matrix that is computed, worked out at these places alone."""
    if of.kind == "sum":
        (whole,) = of.of
        inner = whole.shape[-1]
        return summed(take(whole, places[..., None] * inner + np.arange(inner)))
    return apply(of.kind, *(take(each, places) if each.shape else each for each in of.of))


def _plain(of: Noted, places: Array) -> Noted:
    return expression("take", (of,), places.shape, places)


def stacked(parts: Iterable[Any]) -> Noted:
    """Numbers and vectors one after the other."""
    flat: list[Noted] = []
    for part in map(lifted, parts):
        inner = flag(part) if part.condition else part
        if inner.kind == "take" and inner.size == 1 and inner.of[0].shape == ():
            inner = inner.of[0]
        flat.extend(inner.of if inner.kind == "stack" else (inner,))
    if all(each.kind == "constant" for each in flat):
        return constant(np.concatenate([np.atleast_1d(each.data) for each in flat]))
    if len(flat) == 1 and flat[0].ndim == 1:
        return flat[0]
    return expression("stack", flat, (sum(each.size for each in flat),))


def summed(of: Any) -> Noted:
    """Sum along the last dimension."""
    one = lifted(of)
    one = flag(one) if one.condition else one
    if one.kind == "constant":
        return constant(one.data.sum(axis=-1))
    if one.shape[-1] == 1:
        return take(one, np.arange(one.size).reshape(one.shape[:-1]))
    if one.kind == "mul" and one.ndim == 1:
        for factor, other in (one.of, one.of[::-1]):
            if factor.kind == "constant" and factor.shape and np.count_nonzero(factor.data) == 1:
                (place,) = np.flatnonzero(factor.data)
                return apply("mul", factor.data[place], other[int(place)] if other.shape else other)
    return expression("sum", (one,), one.shape[:-1])

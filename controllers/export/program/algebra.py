"""How expressions are made of expressions: simplified where no number changes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from warmlink.controllers.export.program.expressions import (
    CONDITIONS,
    FUNCTIONS,
    Array,
    Computed,
    constant,
    expression,
    is_number,
    lifted,
    remembered,
    worked_out,
)


def apply(kind: str, *given: Any) -> Computed:
    """A function of expressions, element by element."""
    of = [lifted(each) for each in given]
    made = _applied(kind, of)
    if kind == "select" and made.rest is None and any(each.rest is not None for each in of[1:]):
        made.rest = apply("select", of[0], *(_rest(each) for each in of[1:]))
    return made


def _rest(one: Computed) -> Computed:
    """What rounding has left of a number."""
    return one.rest if one.rest is not None else constant(np.zeros(one.shape))


def with_rest(one: Computed) -> list[Computed]:
    """A number, and what rounding has left of it."""
    return [one, _rest(one)]


def accumulated(value: Computed, change: Any) -> Computed:
    """A sum; what rounding leaves of it goes on with it, where something has been left of the value."""
    if value.rest is None:
        return apply("add", value, change)
    more = apply("add", value.rest, change)
    rest = apply("left", value, more)
    made = apply("add", value, more)
    made.rest = rest
    return made


def _applied(kind: str, of: list[Computed]) -> Computed:
    shape = np.broadcast_shapes(*(each.shape for each in of))
    if kind not in ("and", "or", "not"):
        first = 1 if kind == "select" else 0
        of[first:] = [flag(each) if each.condition else each for each in of[first:]]
    if kind == "select" and not of[0].condition and of[0].kind != "constant":
        of[0] = told_by(of[0]) or apply("not", apply("eq", of[0], 0.0))
    of = [each if each.shape in ((), shape) else _broadcast(each, shape) for each in of]
    if all(each.kind == "constant" for each in of):
        found = worked_out(kind, tuple(of), None)
        return constant(found) if kind not in CONDITIONS else _known(bool(found.all()), shape)
    simple = _simplified(kind, of, shape)
    if simple is not None:
        return simple
    return _settled(expression(kind, of, shape))


def _settled(made: Computed) -> Computed:
    """An expression that follows from the design alone as a constant: computed here, and rounded once."""
    if made.value is None or made.kind == "constant":
        return made
    if made.condition:
        same = bool(np.all(made.value == made.value.flat[0]))
        return _known(bool(made.value.flat[0]), made.shape) if same else made
    if made.kind != "neg":
        made.kind, made.of, made.data = "leaf", (), ("settled", made.serial)
    return made


def hold(one: Computed) -> None:
    """Take for granted that a number is above 0."""
    key = "gt", (id(one), id(constant(0.0))), (), None
    remembered[key] = _known(True, ())


def _known(truth: bool, shape: tuple[int, ...]) -> Computed:
    return constant(np.full(shape, float(truth)))


def _broadcast(one: Computed, shape: tuple[int, ...]) -> Computed:
    return take(one, np.broadcast_to(places_of(one), shape))


def flag(condition: Computed) -> Computed:
    """1 where a condition holds, else 0."""
    if condition.kind == "constant":
        return condition
    return expression("select", (condition, constant(1.0), constant(0.0)), condition.shape)


def told_by(one: Computed) -> Computed | None:
    """The condition that a flag tells of, or None where it is no flag."""
    if one.kind == "select" and is_number(one.of[1], 1.0) and is_number(one.of[2], 0.0):
        return one.of[0]
    return one if one.condition else None


def _simplified(kind: str, of: list[Computed], shape: tuple[int, ...]) -> Computed | None:
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
        if a is b:
            return a
        for one, other in ((a, b), (b, a)):
            if one.kind == "constant" and one.shape == ():
                return other if bool(one.data) is (kind == "and") else _known(kind == "or", shape)
    if kind == "select":
        return _selected(of[0], of[1], of[2], shape)
    return _of_flags(kind, of, shape)


def _of_flags(kind: str, of: list[Computed], shape: tuple[int, ...]) -> Computed | None:
    """What is told by flags alone, as logic."""
    a, b = (*of, *of)[:2]
    if kind == "sub" and is_number(a, 1.0) and told_by(b) is not None and b.shape == shape:
        return flag(apply("not", told_by(b)))
    both = told_by(a), told_by(b)
    logic = {"mul": "and", "smaller": "and", "larger": "or"}.get(kind)
    if len(of) == 2 and logic and both[0] is not None and both[1] is not None:
        return flag(apply(logic, *both))
    for known, other, told in ((a, b, both[1]), (b, a, both[0])):
        number = known.kind == "constant" and known.shape == () and float(known.data) in (0.0, 1.0)
        if logic and number and told is not None and other.shape == shape:
            return other if bool(known.data) is (logic == "and") else _wide(known, shape)
    if kind in ("lt", "le", "gt", "ge") and both[0] is not None and b.kind == "constant" and b.shape == ():
        one, zero = (bool(FUNCTIONS[kind](value, b.data)) for value in (1.0, 0.0))
        if one != zero:
            return both[0] if one else apply("not", both[0])
    return None


def _selected(
    condition: Computed, then: Computed, otherwise: Computed, shape: tuple[int, ...]
) -> Computed | None:
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
    negative = condition.kind == "lt" and is_number(condition.of[1], 0.0)
    if negative and then.kind == "neg" and then.of[0] is otherwise is condition.of[0]:
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


def _same(of: tuple[Computed, ...], *others: Computed) -> bool:
    return all(a is b for a, b in zip(of, others, strict=True))


def _wide(one: Computed, shape: tuple[int, ...]) -> Computed:
    return one if one.shape == shape else _broadcast(one, shape)


def places_of(one: Computed) -> Array:
    """Where in an array each of its elements lies, in the array's shape."""
    return np.arange(one.size).reshape(one.shape)


def take(of: Computed, places: Any) -> Computed:
    """Elements at places of the elements of another expression, shape as the places'."""
    places = np.asarray(places, dtype=int)
    made = _taken(of, places)
    if of.rest is not None and made.rest is None:
        made.rest = take(of.rest, places)
    return made


def _taken(of: Computed, places: Array) -> Computed:
    if of.kind == "constant":
        return constant(of.data.ravel()[places])
    if places.shape == of.shape and np.array_equal(places.ravel(), np.arange(of.size)):
        return of
    if of.kind == "take":
        return take(of.of[0], of.data.ravel()[places])
    if of.kind == "select" and told_by(of) is not None and places.shape == ():
        return flag(take(of.of[0], places))
    if of.kind in ("stack", "weave") and places.size:
        inner = places if of.kind == "stack" else of.data[places]
        start = 0
        for part in of.of:
            if inner.min() >= start and inner.max() < start + part.size:
                return take(part, inner - start)
            start += part.size
    if of.kind == "stack" and places.ndim == 1 and places.size and np.unique(places).size == places.size:
        return _woven(of, places)
    if of.ndim >= 2 and of.kind in _MOVABLE and np.unique(places).size == places.size:
        return _inside(of, places)
    return _plain(of, places)


def _woven(of: Computed, places: Array) -> Computed:
    """Elements of a stack in another order: of each part those that are asked for."""
    parts, at = list[Computed](), list[Array]()

    def add(part: Computed, asked: Array, to: Array) -> None:
        if part.kind not in ("stack", "weave"):
            parts.append(take(part, asked) if part.shape else part)
            at.append(to)
            return
        inner, start = asked if part.kind == "stack" else part.data[asked], 0
        for each in part.of:
            here = (inner >= start) & (inner < start + each.size)
            if here.any():
                add(each, inner[here] - start, to[here])
            start += each.size

    add(of, places, np.arange(places.size))
    return expression("weave", parts, places.shape, np.argsort(np.concatenate(at)))


_MOVABLE = frozenset({"add", "sub", "mul", "sum", "neg"})
"""What may as well be done after elements of a matrix were taken, as those of its upper triangle."""


def _inside(of: Computed, places: Array) -> Computed:
    """Elements of a matrix that is computed, worked out at these places alone."""
    if of.kind == "sum":
        (whole,) = of.of
        inner = whole.shape[-1]
        return summed(take(whole, places[..., None] * inner + np.arange(inner)))
    return apply(of.kind, *(take(each, places) if each.shape else each for each in of.of))


def _plain(of: Computed, places: Array) -> Computed:
    made = expression("take", (of,), places.shape, places)
    return _settled(made) if made.condition else made


def stacked(parts: Iterable[Any]) -> Computed:
    """Numbers and vectors one after the other."""
    flat: list[Computed] = []
    for part in map(lifted, parts):
        inner = flag(part) if part.condition else part
        if inner.kind == "take" and inner.size == 1 and inner.of[0].shape == ():
            inner = inner.of[0]
        flat.extend(inner.of if inner.kind == "stack" else (inner,))
    if all(each.kind == "constant" for each in flat):
        return constant(np.concatenate([np.atleast_1d(each.data) for each in flat]))
    if len(flat) == 1 and flat[0].ndim == 1:
        return flat[0]
    made = expression("stack", flat, (sum(each.size for each in flat),))
    if any(each.rest is not None for each in flat):
        made.rest = stacked([_rest(each) for each in flat])
    return made


def summed(of: Any) -> Computed:
    """Sum along the last dimension."""
    one = lifted(of)
    one = flag(one) if one.condition else one
    if one.kind == "constant":
        return constant(one.data.sum(axis=-1))
    if one.shape[-1] == 1:
        return take(one, places_of(one)[..., 0])
    if one.kind == "mul" and one.ndim == 1:
        for factor, other in (one.of, one.of[::-1]):
            if factor.kind == "constant" and factor.shape and np.count_nonzero(factor.data) == 1:
                (place,) = np.flatnonzero(factor.data)
                return apply("mul", factor.data[place], take(other, place) if other.shape else other)
    return _settled(expression("sum", (one,), one.shape[:-1]))

"""A law is run once with expressions in place of numbers; what it did is kept, with the names that it used.

Functions that are kept whole (`fmus.calls`) become functions of their own. A variable of the law's Python
lends its name to the expression that it held.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from warmlink.controllers.export.program import algebra, expressions
from warmlink.controllers.export.program.expressions import Computed, Given, expression, lifted
from warmlink.controllers.export.program.naming import noticed
from warmlink.controllers.export.program.ranges import is_binary
from warmlink.fmus.component import arithmetic

Place = tuple[str, str]
"""What a leaf is: the record that it stands in, as `state` or `argument`, and its name."""


@dataclass(eq=False)
class TracedFunction:
    """A function of a law that stays one.

    Attributes
    ----------
    name, about : as in the law's Python, and the first sentence of what it says about itself
    arguments : leaves that stand for what it is given
    results : what it gives
    kept : number of first arguments that are also the results; else 0
    paired : number of first arguments that hold two side by side, as all results then do; else 0
    """

    name: str
    about: str
    arguments: list[Computed]
    results: list[Computed]
    kept: int = 0
    spans: list[Span] = field(default_factory=list)
    paired: int = 0


@dataclass
class Span:
    """Expressions that were made while a function of the law ran: those of serials from `first` to `last`."""

    name: str
    about: str
    first: int
    last: int
    depth: int


@dataclass
class Call:
    """A call of a traced function."""

    function: TracedFunction
    given: list[Computed]
    asked: Computed | None = None
    given_at: float = 0.0


class _Tape:
    """What is remembered while a law is run."""

    def __init__(self) -> None:
        self.functions: dict[Any, TracedFunction] = {}
        self.shapes: dict[Any, Any] = {}
        self.names: set[str] = set()
        self.spans: list[list[Span]] = [[]]
        self.slow: tuple[str, ...] = ()


_tape = _Tape()


def leaf(record: str, name: str, shape: tuple[int, ...], value: Any = None) -> Computed:
    """A value that is given; `value` where it follows from the design."""
    made = expression("leaf", (), shape, (record, name))
    made.name = name
    if value is not None:
        made.value, made.origin = value, frozenset({name})
    return made


@contextmanager
def traced(noted: type[Computed], slow: tuple[str, ...] = ()) -> Iterator[None]:
    """Laws that run meanwhile compute with expressions of this class, and lend them their variables' names.

    Of the states named in `slow` what rounding leaves is a state too, with `_rest` after its name.
    """
    global _tape
    expressions.begin(noted)
    _tape = _Tape()
    _tape.slow = slow
    before = sys.getprofile()
    sys.setprofile(noticed)
    try:
        yield
    finally:
        sys.setprofile(before if callable(before) else None)


def run(
    name: str, about: str, function: Callable[..., Mapping[str, Any]], *given: Any, states: bool = False
) -> tuple[TracedFunction, dict[str, Any]]:
    """What a law's function of records does: its results by name, numbers as expressions.

    If these are states, what rounding leaves of them is among the results.
    """
    _tape.spans.append([])
    found = {key: lifted(value) for key, value in function(*given).items()}
    found = {key: algebra.flag(each) if each.condition else each for key, each in found.items()}
    for key in _tape.slow if states else ():
        rest = found[key].rest
        found[f"{key}_rest"] = expressions.constant(np.zeros(found[key].shape)) if rest is None else rest
    for key, each in found.items():
        each.fallback = each.fallback or key
    return TracedFunction(name, about, [], list(found.values()), spans=_tape.spans.pop()), found


def call(function: Callable[..., Any], given: tuple[Any, ...], idle: bool) -> Any:
    """A call of a function that is kept whole; the same arguments give the same function."""
    values: list[Computed] = []
    _mapped(given, lambda each: values.append(lifted(each)) if _is_value(each) else None)
    sure = idle and is_binary(values[-1])
    key = _like((function, _mapped(given, _shape), sure, idle), [each.rest is not None for each in values])
    if key not in _tape.functions:
        _tape.functions[key], _tape.shapes[key] = _function(function, given, idle, sure)
    whole, (like, rests) = _tape.functions[key], _tape.shapes[key]
    arguments = [
        one
        for each, carried in zip(values, key[-1], strict=True)
        for one in algebra.with_rest(each)[: 1 + carried]
    ]
    asked = arguments[-1] if idle else None
    flat = [algebra.flag(each) if each.condition else each for each in arguments]
    if idle and asked is not None:
        if asked.kind == "constant" and not asked.data > 0:
            return given[0]
        flat[-1] = flat[-1] if algebra.told_by(asked) is None else lifted(1.0)
        asked = algebra.apply("gt", asked, 0.0)
        asked = None if asked.kind == "constant" else asked
    this = Call(whole, flat, asked)
    results = []
    for k, each in enumerate(whole.results):
        same = [i for i, argument in enumerate(whole.arguments) if each is argument]
        if not idle and same:
            own = whole.paired <= same[0] and whole.paired
            results.append(arithmetic.beside(*[flat[same[0]]] * 2) if own else flat[same[0]])
            continue
        of = [*flat, *([asked] if asked is not None else [])]
        shape = (2 * each.size,) if whole.paired else each.shape
        made = expression("result", of, shape, (id(this), k))
        made.data, made.fallback = (this, k), each.name or each.fallback
        results.append(made)
    found, carried = iter(results), iter(rests)

    def one(each: Any) -> Any:
        value = next(found)
        if next(carried):
            value.rest = next(found)
        return value

    return _mapped(like, one)


def _like(key: tuple[Any, ...], carried: list[bool]) -> tuple[Any, ...]:
    """The key of a function that takes what is carried on of these arguments; if idle, of more too."""
    for known in _tape.functions if key[-1] else ():
        if known[: len(key)] == key and all(a or not b for a, b in zip(known[-1], carried, strict=True)):
            return known
    return *key, tuple(carried)


def _function(
    function: Callable[..., Any], given: tuple[Any, ...], idle: bool, sure: bool
) -> tuple[TracedFunction, Any]:
    """The function for arguments of a shape, and what its results are put together like.

    If it is idle where its last argument is 0, it knows that this is 1 if `sure`, else that it is above 0.
    """
    code: Any = inspect.unwrap(function)
    names = code.__code__.co_varnames[: code.__code__.co_argcount]
    name = _fresh(code.__name__.strip("_"))
    arguments: list[Computed] = []

    def symbols(value: Any, told: str) -> Any:
        if isinstance(value, tuple):
            fields = getattr(value, "_fields", [f"{told}_{i}" for i in range(len(value))])
            parts = [symbols(each, name) for each, name in zip(value, fields, strict=True)]
            return value._make(parts) if hasattr(value, "_make") else tuple(parts)
        if callable(value) and not isinstance(value, type | Given) and not _is_value(value):
            return partial(recorded, value)
        if not _is_value(value):
            return value
        made = leaf("argument", f"{name}.{len(arguments)}", _shape_of_one(lifted(value), pairs))
        made.name = told
        arguments.append(made)
        rest = lifted(value).rest
        if rest is not None:
            made.rest = symbols(rest, f"{told}_rest")
        return made

    pairs = True
    count = getattr(function, "paired", 0)
    first = [symbols(value, told) for value, told in zip(given[:count], names, strict=False)]
    paired, pairs = len(arguments), False
    rest = [symbols(value, told) for value, told in zip(given[count:], names[count:], strict=False)]
    inside = (*first, *rest)
    if idle:  # it runs only where its last argument is above 0
        algebra.hold(arguments[-1])
        inside = (*inside[:-1], expressions.constant(1.0)) if sure else inside
    _tape.spans.append([])
    result = code(*inside)
    rests: list[bool] = []
    _mapped(result, lambda each: rests.append(lifted(each).rest is not None))
    if idle:  # its results are its first arguments, and what is carried on of these
        rests.clear()
        _mapped(inside[0], lambda each: rests.append(each.rest is not None))
    flat, carried = list[Computed](), iter(rests)
    _mapped(result, lambda each: flat.extend(algebra.with_rest(lifted(each))[: 1 + next(carried)]))
    for each in flat:
        if each.rest is not None:
            each.rest.fallback = each.rest.fallback or f"{each.name or each.fallback or 'value'}_rest"
    flat = [algebra.flag(each) if each.condition else each for each in flat]
    kept = len(flat) if idle else 0
    about = (code.__doc__ or "").strip().partition("\n")[0]
    return TracedFunction(name, about, arguments, flat, kept, _tape.spans.pop(), paired), (result, rests)


def _shape_of_one(value: Computed, paired: bool) -> tuple[int, ...]:
    """The shape of a value, or of one of the two that lie side by side in it."""
    if not paired:
        return value.shape
    return (value.size // 2,) if value.size > 2 else ()


def recorded(function: Callable[..., dict[str, Any]], *given: Any) -> dict[str, Any]:
    """A call of a law's function of records, as its `begin`, which stays one; its results by name."""
    if not all(isinstance(each, Given) for each in given):
        return function(*given)
    whole, names = of_records(function, *given)
    this = Call(whole, [])
    found = {}
    for k, (name, each) in enumerate(zip(names, whole.results, strict=True)):
        found[name] = expression("result", (), each.shape, (id(this), k))
        found[name].data, found[name].fallback = (this, k), name
    for name in _tape.slow:
        found[name].rest = found.pop(f"{name}_rest")
    return found


def of_records(function: Callable[..., Any], *given: Given) -> tuple[TracedFunction, tuple[str, ...]]:
    """A law's function of records as a function without arguments, and the names of its results."""
    key = function, given
    if key not in _tape.functions:
        code: Any = function
        about = (code.__doc__ or "").strip().partition("\n")[0]
        made, found = run(_fresh(code.__name__), about, function, *given, states=True)
        _tape.functions[key], _tape.shapes[key] = made, tuple(found)
    return _tape.functions[key], _tape.shapes[key]


def functions() -> list[TracedFunction]:
    """Every function so far, each after those that it calls."""
    return list(_tape.functions.values())


def _is_value(value: Any) -> bool:
    return isinstance(value, Computed) or (isinstance(value, float) or hasattr(value, "dtype"))


def _shape(value: Any) -> Any:
    return ("value", lifted(value).shape) if _is_value(value) else _Same(value)


@dataclass(frozen=True)
class _Same:
    """An argument that makes the function another one."""

    value: Any

    def __eq__(self, other: object) -> bool:
        mine = self.value
        return isinstance(other, _Same) and type(mine) is type(other.value) and mine == other.value

    def __hash__(self) -> int:
        return hash((type(self.value), self.value))


def _mapped(value: Any, change: Callable[[Any], Any]) -> Any:
    if not isinstance(value, tuple):
        return change(value)
    parts = [_mapped(each, change) for each in value]
    return value._make(parts) if hasattr(value, "_make") else tuple(parts)


def _fresh(name: str) -> str:
    made, count = name, 1
    while made in _tape.names:
        count += 1
        made = f"{name}_{count}"
    _tape.names.add(made)
    return made

"""A law is run once with expressions in place of numbers; what it did is kept, with the names that it used.

Functions that are kept whole (`fmus.calls`) become functions of their own. A variable of the law's Python
lends its name to the expression that it held.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from warmlink.controllers.export.program import algebra
from warmlink.controllers.export.program.algebra import expression, lifted, stacked, take
from warmlink.controllers.export.program.expressions import Noted
from warmlink.fmus.component import arithmetic

Place = tuple[str, str]
"""What a leaf is: the record that it stands in, as `state` or `argument`, and its name."""


class Given:
    """A record of a law: its states, inputs or parameters by name."""

    def __init__(self, values: dict[str, Noted]) -> None:
        self.__dict__.update(values)

    def __getitem__(self, name: str) -> Noted:
        found: Noted = self.__dict__[name]
        return found


@dataclass(eq=False)
class TracedFunction:
    """A function of a law that stays one.

    Attributes
    ----------
    name, about : as in the law's Python, and the first sentence of what it says about itself
    arguments : leaves that stand for what it is given
    results : what it gives
    kept : number of first arguments that are also the results; else 0
    """

    name: str
    about: str
    arguments: list[Noted]
    results: list[Noted]
    kept: int = 0
    spans: list[Span] = field(default_factory=list)


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
    given: list[Noted]
    asked: Noted | None = None
    given_at: float = 0.0


class _Tape:
    """What is remembered while a law is run."""

    def __init__(self) -> None:
        self.functions: dict[Any, TracedFunction] = {}
        self.shapes: dict[Any, Any] = {}
        self.names: set[str] = set()
        self.spans: list[list[Span]] = [[]]


_tape = _Tape()


def leaf(record: str, name: str, shape: tuple[int, ...], value: Any = None) -> Noted:
    """A value that is given; `value` where it follows from the design."""
    made = expression("leaf", (), shape, (record, name))
    made.name = name
    if value is not None:
        made.value, made.origin = value, frozenset({name})
    return made


@contextmanager
def traced() -> Iterator[None]:
    """Laws that run meanwhile are remembered by what they name."""
    global _tape
    algebra.forget()
    _tape = _Tape()
    before = sys.getprofile()
    sys.setprofile(_noticed)
    try:
        yield
    finally:
        sys.setprofile(before if callable(before) else None)


def run(
    name: str, about: str, function: Callable[..., Mapping[str, Any]], *given: Any
) -> tuple[TracedFunction, dict[str, Any]]:
    """What a law's function of records does: its results by name, numbers as expressions."""
    _tape.spans.append([])
    found = {key: lifted(value) for key, value in function(*given).items()}
    found = {key: algebra.flag(each) if each.condition else each for key, each in found.items()}
    for key, each in found.items():
        each.fallback = each.fallback or key
    return TracedFunction(name, about, [], list(found.values()), spans=_tape.spans.pop()), found


def call(function: Callable[..., Any], given: tuple[Any, ...], idle: bool) -> Any:
    """A call of a function that is kept whole; the same arguments give the same function."""
    if getattr(function, "paired", 0):
        return _both(function, given)
    arguments, shape = [], _mapped(given, _shape)
    _mapped(given, lambda each: arguments.append(lifted(each)) if _is_value(each) else None)
    key = function, shape, idle
    if key not in _tape.functions:
        _tape.functions[key], _tape.shapes[key] = _function(function, given, idle)
    whole, like = _tape.functions[key], _tape.shapes[key]
    asked = arguments[-1] if idle else None
    flat = [algebra.flag(each) if each.condition else each for each in arguments]
    if idle and asked is not None:
        if asked.kind == "constant" and asked.data == 0:
            return given[0]
        flat[-1] = flat[-1] if algebra.told_by(asked) is None else lifted(1.0)
        asked = algebra.apply("gt", asked, 0.0)
    this = Call(whole, flat, asked)
    results = []
    for k, each in enumerate(whole.results):
        if not idle and any(each is argument for argument in whole.arguments):
            results.append(flat[[each is argument for argument in whole.arguments].index(True)])
            continue
        of = [*flat, *([asked] if asked is not None else [])]
        made = expression("result", of, each.shape, (id(this), k))
        made.data, made.fallback = (this, k), each.name or each.fallback
        results.append(made)
    rest = iter(results)
    return _mapped(like, lambda each: next(rest))


def _function(function: Callable[..., Any], given: tuple[Any, ...], idle: bool) -> tuple[TracedFunction, Any]:
    """The function for arguments of a shape, and what its results are put together like."""
    code = getattr(function, "__wrapped__", function)
    names = code.__code__.co_varnames[: code.__code__.co_argcount]
    name = _fresh(code.__name__.strip("_"))
    arguments: list[Noted] = []

    def symbols(value: Any, told: str) -> Any:
        if isinstance(value, tuple):
            fields = getattr(value, "_fields", [f"{told}_{i}" for i in range(len(value))])
            parts = [symbols(each, name) for each, name in zip(value, fields, strict=True)]
            return value._make(parts) if hasattr(value, "_make") else tuple(parts)
        if callable(value) and not isinstance(value, type | Given) and not _is_value(value):
            return partial(recorded, value)
        if not _is_value(value):
            return value
        made = leaf("argument", f"{name}.{len(arguments)}", lifted(value).shape)
        made.name = told
        arguments.append(made)
        return made

    inside = tuple(symbols(value, told) for value, told in zip(given, names, strict=False))
    if idle:  # it runs only where its last argument is above 0
        algebra.hold(arguments[-1])
    _tape.spans.append([])
    result = code(*inside)
    flat: list[Noted] = []
    _mapped(result, lambda each: flat.append(lifted(each)))
    flat = [algebra.flag(each) if each.condition else each for each in flat]
    count = len(flat)
    about = (code.__doc__ or "").strip().partition("\n")[0]
    kept = count if idle else 0
    return TracedFunction(name, about, arguments, flat, kept, _tape.spans.pop()), result


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
    return found


def of_records(function: Callable[..., Any], *given: Given) -> tuple[TracedFunction, tuple[str, ...]]:
    """A law's function of records as a function without arguments, and the names of its results."""
    key = function, given
    if key not in _tape.functions:
        code: Any = function
        about = (code.__doc__ or "").strip().partition("\n")[0]
        made, found = run(_fresh(code.__name__), about, function, *given)
        _tape.functions[key], _tape.shapes[key] = made, tuple(found)
    return _tape.functions[key], _tape.shapes[key]


def functions() -> list[TracedFunction]:
    """Every function so far, each after those that it calls."""
    return list(_tape.functions.values())


def _both(function: Callable[..., Any], given: tuple[Any, ...]) -> Any:
    """A function of each of two that lie side by side."""
    one, paired = function.__dict__["one"], function.__dict__["paired"]
    found = []
    for k in range(2):
        sides = _mapped(given[:paired], partial(arithmetic.side, k))
        found.append(call(getattr(one, "__wrapped__", one), (*sides, *given[paired:]), False))
    others: list[Any] = []
    _mapped(found[1], others.append)
    rest = iter(others)
    return _mapped(found[0], lambda each: _beside(each, next(rest)))


def _beside(one: Noted, other: Noted) -> Noted:
    size = one.size
    places = [place for i in range(size) for place in (i, size + i)]
    return take(stacked((one, other)), places)


def _is_value(value: Any) -> bool:
    return isinstance(value, Noted) or (isinstance(value, float) or hasattr(value, "dtype"))


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


_NOT_ITS_NAMES = ("arithmetic.py", "matrices.py", "calls.py", "instance.py")


def _noticed(frame: Any, event: str, result: Any) -> None:
    """Name what the variables of a law's function hold, when it returns."""
    if event != "return":
        return
    path = Path(frame.f_code.co_filename)
    if (
        path.parent.name == "program"
        or path.name.startswith("<")
        or path.name in _NOT_ITS_NAMES
        or "numpy" in path.parts
    ):
        return
    arguments = frame.f_code.co_varnames[: frame.f_code.co_argcount]
    for name, value in frame.f_locals.items():
        if name != "self" and not name.startswith("."):
            _named(value, name.strip("_"), "fallback" if name in arguments else "name")
    if isinstance(result, tuple):
        _named(result, frame.f_code.co_name.strip("_"), "fallback")


def _named(value: Any, name: str, kind: str, depth: int = 0) -> None:
    if isinstance(value, Noted):
        if value.kind != "constant" and not (value.kind == "leaf" and value.data[0] != "settled"):
            setattr(value, kind, getattr(value, kind) or name)
            if value.kind == "select" and algebra.told_by(value) is not None:
                _named(value.of[0], name, kind, depth)
    elif isinstance(value, dict) and depth < 2:
        for key, each in value.items():
            _named(each, str(key), "fallback", depth + 1)
    elif isinstance(value, (tuple, list)) and depth < 3 and len(value) < 40:
        fields = getattr(value, "_fields", None)
        for i, each in enumerate(value):
            _named(each, fields[i] if fields else f"{name}_{i + 1}", kind, depth + 1)

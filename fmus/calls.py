"""Functions that the generated C contains once and calls, rather than written out at each use."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache, wraps
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

Called = TypeVar("Called", bound=Callable[..., Any])


def kept_whole(function: Called) -> Called:
    """Mark a function of numbers that the generated C is to contain once.

    With floats and with CasADi's SX it is an ordinary function. Where its first number is an MX, of which the
    code of samples is generated, a call of it stays a call.

    Parameters
    ----------
    function : takes numbers, vectors, and named tuples of them, by position, and returns the same; integers
        among the arguments become constants of the C
    """
    return _kept(function, idle=False)


def idle_at_zero(function: Called) -> Called:
    """Mark a function, kept whole, that returns its first argument as it is where its last one is 0.

    It must do so by its own arithmetic too; floats and the C skip it there.
    """
    return _kept(function, idle=True)


def _kept(function: Called, idle: bool) -> Called:
    @wraps(function)
    def called(*given: Any) -> Any:
        first: Any = given  # it decides, since floats must not wait for a search through all
        while isinstance(first, tuple):
            first = first[0]
        if not _is_graph(first):
            skipped = idle and isinstance(given[-1], float) and given[-1] == 0
            return given[0] if skipped else function(*given)
        given = _as_graphs(given)
        whole = _whole(function, _shape(given), idle)
        arguments = [leaf for leaf in _leaves(given) if _is_graph(leaf)]
        results = whole.function.call([arguments[i] for i in whole.used])
        return _rebuilt(whole.result, iter(results))

    return cast(Called, called)


class _Symbol(NamedTuple):
    """Structure of a vector or matrix that differs from call to call."""

    size: tuple[int, int]
    columns: tuple[int, ...]
    rows: tuple[int, ...]


class _Whole(NamedTuple):
    """A CasADi function, which of the arguments it uses, and how its results are put together."""

    function: Any
    used: Sequence[int]
    result: Any


@cache
def _whole(function: Callable[..., Any], shape: Any, idle: bool) -> _Whole:
    """The function for arguments of a shape, as `_shape` gives it; the same one each time.

    What is idle most of the time is made of calls and loops, which are short; all else is written out.
    """
    import casadi

    kind: Any = casadi.MX if idle else casadi.SX
    symbols: list[Any] = []

    def filled(part: Any) -> Any:
        if isinstance(part, _Symbol):
            symbols.append(kind.sym("a", casadi.Sparsity(*part.size, part.columns, part.rows)))
            return symbols[-1]
        return _like(part, [filled(each) for each in part]) if isinstance(part, tuple) else part

    given = filled(shape)
    result = function(*given)
    results = [kind(leaf) for leaf in _leaves(result)]
    everything = casadi.vertcat(*(casadi.vec(each) for each in results))
    unchanged = sum(1 for _ in _leaves(given[0])) if idle else 0
    used = [i for i, s in enumerate(symbols) if i < unchanged or casadi.depends_on(everything, s)]
    arguments = [symbols[i] for i in used]
    name = function.__name__.strip("_")
    if not idle:
        return _Whole(casadi.Function(name, arguments, casadi.cse(results)), used, result)
    run = casadi.Function(f"{name}_run", arguments, [casadi.densify(each) for each in results])
    skip = casadi.Function(f"{name}_skip", arguments, arguments[:unchanged])
    return _Whole(casadi.Function.if_else(name, run, skip), [len(symbols) - 1, *used], result)


def _shape(value: Any) -> Any:
    """What a call of given arguments has in common with others: all but the expressions themselves."""
    if isinstance(value, tuple):
        return _like(value, [_shape(each) for each in value])
    if _is_graph(value):
        sparsity = value.sparsity()
        return _Symbol(sparsity.size(), tuple(sparsity.colind()), tuple(sparsity.row()))
    return value


def _as_graphs(value: Any) -> Any:
    """The same with expressions for its numbers, integers aside, and dense vectors: such calls share C."""
    import casadi

    if isinstance(value, tuple):
        return _like(value, [_as_graphs(each) for each in value])
    graph = casadi.MX(value) if isinstance(value, float | np.ndarray) else value
    return casadi.densify(graph) if _is_graph(graph) and graph.shape[1] == 1 else graph


def _leaves(value: Any) -> Iterator[Any]:
    if isinstance(value, tuple):
        for each in value:
            yield from _leaves(each)
    else:
        yield value


def _rebuilt(value: Any, leaves: Iterator[Any]) -> Any:
    if isinstance(value, tuple):
        return _like(value, [_rebuilt(each, leaves) for each in value])
    return next(leaves)


def _like(value: Any, parts: Sequence[Any]) -> Any:
    """Named or plain tuple like another, of other parts."""
    return value._make(parts) if hasattr(value, "_make") else tuple(parts)


def _is_graph(value: Any) -> bool:
    """Whether a value is an expression of which the functions that it calls stay apart."""
    return type(value).__name__ == "MX"

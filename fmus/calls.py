"""Functions that the generated C contains once and calls, rather than written out at each use."""

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

    @wraps(function)
    def called(*given: Any) -> Any:
        first: Any = given  # it decides, since floats must not wait for a search through all
        while isinstance(first, tuple):
            first = first[0]
        if not _is_graph(first):
            return function(*given)
        given = _as_graphs(given)
        whole = _whole(function, _shape(given))
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
def _whole(function: Callable[..., Any], shape: Any) -> _Whole:
    """The function for arguments of a shape, as `_shape` gives it; the same one each time."""
    import casadi

    symbols: list[Any] = []

    def filled(part: Any) -> Any:
        if isinstance(part, _Symbol):
            symbols.append(casadi.SX.sym("a", casadi.Sparsity(*part.size, part.columns, part.rows)))
            return symbols[-1]
        return _like(part, [filled(each) for each in part]) if isinstance(part, tuple) else part

    result = function(*filled(shape))
    results = casadi.cse([casadi.SX(leaf) for leaf in _leaves(result)])
    everything = casadi.vertcat(*(casadi.vec(each) for each in results))
    used = [i for i, symbol in enumerate(symbols) if casadi.depends_on(everything, symbol)]
    name = function.__name__.strip("_")
    return _Whole(casadi.Function(name, [symbols[i] for i in used], results), used, result)


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

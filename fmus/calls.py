"""Functions that the generated C contains once and calls, rather than written out at each use.

They keep long laws short in C: written out, the native observer's step takes 4.9 us, not 1.3, and its FMU has
640 kB, not 370.
"""

from collections.abc import Callable
from functools import cache, partial, wraps
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

from warmlink.fmus.component.arithmetic import Traced, beside, side

Called = TypeVar("Called", bound=Callable[..., Any])


def as_c_function(function: Called, idle: bool = False) -> Called:
    """Mark a function of numbers that the generated C is to contain once.

    With floats and with CasADi's SX it is an ordinary function. Where its first number is an MX, of which the
    code of samples is generated, a call of it stays a call.

    Parameters
    ----------
    function : takes numbers, vectors, and named tuples of them, by position, and returns the same; integers
        among the arguments become constants of the C
    idle : as `skip_if_zero` says
    """

    @wraps(function)
    def either(*given: Any) -> Any:
        first: Any = given  # it decides, since floats must not wait for a search through all
        while isinstance(first, tuple):
            first = first[0]
        if not _is_graph(first):
            if isinstance(first, Traced):
                return first.whole(function, given, idle)
            skipped = idle and isinstance(given[-1], float) and given[-1] == 0
            return given[0] if skipped else function(*given)
        given = _mapped(given, _as_graph)
        # What the call has in common with others: all but the expressions themselves.
        shape = _mapped(given, lambda leaf: _Symbol(leaf.sparsity().serialize()) if _is_graph(leaf) else leaf)
        whole, used, result = _whole(function, shape, _mapped(shape, type), idle)
        arguments = [leaf for leaf in _leaves(given) if _is_graph(leaf)]
        results = iter(whole.call([arguments[i] for i in used]))
        return _mapped(result, lambda leaf: next(results))

    return cast(Called, either)


def skip_if_zero(function: Called) -> Called:
    """Mark a function, kept whole, that returns its first argument as it is where its last one is 0.

    It must do so by its own arithmetic too; floats and the C skip it there.
    """
    return as_c_function(function, idle=True)


def vectorised_pair(one: Called, paired: int) -> Called:
    """A function, kept whole, for both at once of two that lie side by side, from that of one of them.

    The first arguments, so many as are `paired`, and all results hold two of each number, one beside the
    other (`arithmetic.beside`). The C goes through both in a loop, of which compilers make vectors.
    """

    @wraps(one)
    def both(*given: Any) -> Any:
        found = [one(*_mapped(given[:paired], partial(side, k)), *given[paired:]) for k in range(2)]
        others = iter(_leaves(found[1]))
        return _mapped(found[0], lambda leaf: beside(leaf, next(others)))

    both.__dict__.update(paired=paired, one=one)
    return as_c_function(cast(Called, both))


class Written(NamedTuple):
    """How a CasADi function is written in C.

    Attributes
    ----------
    function : what it does; of two side by side to one of them, where its first argument is not 0 to those
        after that
    paired : how many of the first arguments hold two side by side
    otherwise : what is done in its place where its first argument is 0: a function, or `IDLE`
    by_hand : name under which C written by hand has it, which takes numbers and gives a vector
    """

    function: Any
    paired: int = 0
    otherwise: Any = None
    by_hand: str = ""


IDLE = "idle"
"""The arguments after the first one are the results."""


def written(function: Any) -> Written:
    """How a CasADi function is written in C."""
    return _WRITTEN[function.__hash__()][1] if function.__hash__() in _WRITTEN else Written(function)


_WRITTEN: dict[int, tuple[Any, Written]] = {}
"""By its hash a function, kept lest another gets that hash."""


def called(function: Any, how: Written | None = None) -> Any:
    """A CasADi function whose calls stay calls where expressions are written out."""
    import casadi

    given = function.mx_in()
    results, asked = function.call(given), []
    if how and how.otherwise:
        asked = [casadi.MX.sym("asked")]
        others = given if how.otherwise is IDLE else how.otherwise.call(given)
        results = [casadi.if_else(asked[0], *each) for each in zip(results, others, strict=False)]
    kept = casadi.Function(function.name(), [*asked, *given], results, {"never_inline": True})
    _WRITTEN[kept.__hash__()] = kept, how or Written(function)
    return kept


def by_hand(name: str, arguments: list[Any], result: Any) -> Any:
    """A CasADi function (MX) of numbers that C written by hand replaces: it has no slope."""
    import casadi

    kept = casadi.Function(
        name, arguments, [result], {"never_inline": True, "forward_options": {"never_inline": False}}
    )
    _WRITTEN[kept.__hash__()] = kept, Written(kept, by_hand=name)
    return kept


class _Symbol(str):
    """Structure, as text, of a vector or matrix that differs from call to call."""

    __slots__ = ()


@cache
def _whole(function: Callable[..., Any], shape: Any, kinds: Any, idle: bool) -> tuple[Any, list[int], Any]:
    """The CasADi function for arguments of a shape, whose symbols stand for expressions; always the same.

    The kinds of the arguments tell what is equal apart, as True and 1.

    Beside it which of the arguments it uses, and a result that shows how its results are put together. What
    is idle most of the time is made of calls and loops, which are short; all else is written out.
    """
    import casadi

    kind: Any = casadi.MX if idle else casadi.SX
    symbols: list[Any] = []

    def filled(leaf: Any) -> Any:
        if isinstance(leaf, _Symbol):
            symbols.append(kind.sym("a", casadi.Sparsity.deserialize(leaf)))
            return symbols[-1]
        return leaf

    given = _mapped(shape, filled)
    result = function(*given)
    results = [kind(leaf) for leaf in _leaves(result)]
    everything = casadi.vertcat(*(casadi.vec(each) for each in results))
    unchanged = len(_leaves(given[0])) if idle else 0
    used = [i for i, s in enumerate(symbols) if i < unchanged or casadi.depends_on(everything, s)]
    arguments = [symbols[i] for i in used]
    name = function.__name__.strip("_")
    if idle:
        run = casadi.Function(name, arguments, [casadi.densify(each) for each in results])
        return called(run, Written(run, otherwise=IDLE)), [len(symbols) - 1, *used], result
    how = Written(casadi.Function(name, arguments, casadi.cse(results)))
    plain, pairs = how.function, len(_leaves(given[: getattr(function, "paired", 0)]))
    if pairs:  # One of two side by side is what comes of it beside itself.
        halves = [casadi.SX.sym("a", s.shape[0] // 2) if i < pairs else s for i, s in enumerate(symbols)]
        both = plain.call([beside(halves[i], halves[i]) if i < pairs else halves[i] for i in used])
        one = casadi.Function(name, [halves[i] for i in used], casadi.cse([side(0, each) for each in both]))
        how = Written(one, sum(i < pairs for i in used))
    return called(plain, how), used, result


def _as_graph(value: Any) -> Any:
    """An expression for a number, integers aside, and dense where it is a vector: such calls share C."""
    import casadi

    graph = casadi.MX(value) if isinstance(value, float | np.ndarray) else value
    return casadi.densify(graph) if _is_graph(graph) and graph.shape[1] == 1 else graph


def _mapped(value: Any, change: Callable[[Any], Any]) -> Any:
    """Nested named and plain tuples like others, of changed leaves."""
    if not isinstance(value, tuple):
        return change(value)
    parts = [_mapped(each, change) for each in value]
    return value._make(parts) if hasattr(value, "_make") else tuple(parts)


def _leaves(value: Any) -> list[Any]:
    leaves: list[Any] = []
    _mapped(value, leaves.append)
    return leaves


def _is_graph(value: Any) -> bool:
    """Whether a value is an expression (MX) in which function calls stay calls."""
    return type(value).__name__ == "MX"

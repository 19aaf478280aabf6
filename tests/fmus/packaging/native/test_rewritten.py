"""CasADi's functions written anew in C compute what they computed, however they are called."""

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

import casadi
import numpy as np
import pytest

from tests.built import call_of
from warmlink.fmus.calls import IDLE, Written, called
from warmlink.fmus.packaging.native.c_code import functions_text
from warmlink.fmus.packaging.native.casadi_code import function

SIZE = 4
Graph = Callable[[casadi.MX, casadi.MX], Any]


@cache
def plain(name: str) -> casadi.Function:
    """Two vectors of one, as a function of plain numbers."""
    given = casadi.SX.sym("given", SIZE)
    return called(casadi.Function(name, [given], [casadi.sin(given), 3.0 * given]))


def of_one(name: str) -> casadi.Function:
    given = casadi.SX.sym("given")
    return called(casadi.Function(name, [given], [casadi.sin(given), 3.0 * given]))


def calling(name: str) -> casadi.Function:
    """The same sizes as a plain function, but a function of calls, and with other results."""
    given = casadi.MX.sym("given", SIZE)
    one, other = plain("inner")(given)
    return called(casadi.Function(name, [given], [one + other, casadi.cos(other)]))


def idle(size: int = SIZE) -> casadi.Function:
    """Two vectors, moved by a third where the first argument says so."""
    pair = [casadi.MX.sym(name, size) for name in "abc"]
    one, other = (plain if size == SIZE else of_one)("inner")(pair[2])
    run = casadi.Function("idle", pair, [2.0 * pair[0] + one, pair[1] + other])
    return called(run, Written(run, otherwise=IDLE))


def same_names(x: casadi.MX, use: casadi.MX) -> Any:
    return casadi.vertcat(*plain("same")(x), *calling("same")(use * x))


def one_result_of_two(x: casadi.MX, use: casadi.MX) -> Any:
    return casadi.vertcat(plain("two")(x)[1], of_one("two")(use)[0])


def one_idle_result_of_two(x: casadi.MX, use: casadi.MX) -> Any:
    return casadi.vertcat(idle()(use, x, 2.0 * x, x)[1], idle(1)(use, use, x[0], x[1])[0])


def one_vector_for_both(x: casadi.MX, use: casadi.MX) -> Any:
    (vector, _) = plain("vector")(x)
    found = idle()(use, vector, vector, x)
    return casadi.vertcat(*plain("after")(found[0]), *plain("after")(found[1]))


def exchanged_vectors(x: casadi.MX, use: casadi.MX) -> Any:
    first = idle()(use, *plain("vector")(x), x)
    second = idle()(1.0 - use, first[1], first[0], x)
    return casadi.vertcat(*plain("after")(second[0]), *plain("after")(second[1]))


def empty_and_constant_results(x: casadi.MX, use: casadi.MX) -> Any:
    given = casadi.SX.sym("given", SIZE)
    results = [casadi.SX(2, 2), casadi.SX(1.5), casadi.SX(0, 1), casadi.if_else(given > 0, given, -2 * given)]
    nothing, constant, none, chosen = called(casadi.Function("int", [given], results))(x)
    return casadi.vertcat(casadi.vec(nothing), constant, none, use * chosen)


GRAPHS = (
    same_names,
    one_result_of_two,
    one_idle_result_of_two,
    one_vector_for_both,
    exchanged_vectors,
    empty_and_constant_results,
)


@pytest.mark.parametrize("graph", GRAPHS, ids=lambda graph: graph.__name__)
def test_it_computes_what_casadi_computes(graph: Graph) -> None:
    x, use = casadi.MX.sym("x", SIZE), casadi.MX.sym("use")
    whole = function("whole", [x, use], graph(x, use))
    text = functions_text([whole], ())
    text += "void call(const double *x, const double *use, double *y) { whole_of(x, use, y); }\n"
    call = call_of(text)
    values = np.array([0.5, -1.0, 2.0, 3.0])
    for use_value in (0.0, 1.0):
        given = np.array([use_value])
        found = np.full(whole.size1_out(0), np.nan)
        call(*(ctypes.c_void_p(each.ctypes.data) for each in (values, given, found)))
        assert found == pytest.approx(whole(values, given).full().ravel(), rel=1e-14, abs=1e-15)

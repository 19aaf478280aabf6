"""Functions that the generated C calls, and those that it skips while they change nothing."""

import ctypes
import itertools
import re
from functools import partial
from typing import NamedTuple

import casadi
import numpy as np
import pytest

from tests.built import call_of
from warmlink.fmus.calls import as_c_function, skip_if_zero, vectorised_pair
from warmlink.fmus.component.arithmetic import Number
from warmlink.fmus.packaging.native.c_code import functions_text


class Pair(NamedTuple):
    first: Number
    second: Number


@skip_if_zero
def moved(pair: Pair, by: Number, use: Number) -> Pair:
    return Pair(pair.first + use * by, pair.second * (1.0 + use))


def graph() -> casadi.Function:
    first, second, by, use = (
        casadi.MX.sym(name, size) for name, size in (("a", 3), ("b", 1), ("c", 3), ("d", 1))
    )
    found = moved(moved(Pair(first, second), by, use), by, use)
    return casadi.Function("graph", [first, second, by, use], list(found))


@pytest.mark.parametrize("use", [0.0, 1.0])
def test_every_arithmetic_gives_the_same(use: float) -> None:
    first, second = (each.full().ravel() for each in graph()([1.0, 2.0, 3.0], 4.0, [0.5, 0.25, 0.125], use))
    found = moved(
        moved(Pair(casadi.DM([1, 2, 3]), 4.0), casadi.DM([0.5, 0.25, 0.125]), use),
        casadi.DM([0.5, 0.25, 0.125]),
        use,
    )
    assert first.tolist() == casadi.DM(found.first).full().ravel().tolist()
    assert second.tolist() == [found.second]


def test_what_is_idle_is_written_once_and_skipped() -> None:
    text = functions_text([graph()], ())
    assert text.count("static void moved") == 1
    assert "moved_skip" not in text, "what is skipped needs no function"
    in_lanes = functions_text([graph()], (), lanes=4)
    assert len(re.findall(r"if \(any_of\(.+\)\) \{", in_lanes)) == 2, "it runs where any run needs it"


def chain(kept: bool) -> casadi.Function:
    """Calls that are idle or not, one after the other; what lies between them may be read once more."""
    first, by, uses = (casadi.MX.sym(name, 3) for name in "abc")
    pairs = [Pair(2.0 * first, 3.0 * first)]
    for k in range(3):
        pairs.append(moved(pairs[-1], by, uses[k]))
    both = casadi.vertcat(*pairs[3], *(pairs[1] if kept else ()))
    return casadi.Function("chain", [first, by, uses], [2.0 * both])


@pytest.mark.parametrize("kept", [False, True])
def test_what_is_left_as_it_was_is_moved_by_its_pointer_alone(kept: bool) -> None:
    whole = chain(kept)
    text = functions_text([whole], ())
    assert re.search(r"p(t\d+)=\1;", text)
    text += "void call(const double *const *a, double *y) { chain_of(a[0], a[1], a[2], y); }\n"
    call = call_of(text)
    found = np.zeros(whole.size1_out(0))
    for uses in itertools.product((0.0, 1.0), repeat=3):
        given = [np.array(each) for each in ([1.0, 2.0, 3.0], [0.5, 0.25, 0.125], uses)]
        pointers = (ctypes.c_void_p * 3)(*(each.ctypes.data for each in given))
        call(pointers, ctypes.c_void_p(found.ctypes.data))
        assert found.tolist() == whole(*given).full().ravel().tolist()


@as_c_function
def picked(given: Number, place: int) -> Number:
    return 2.0 * given[place]


def test_what_differs_by_a_whole_number_is_another_function() -> None:
    given = casadi.MX.sym("given", 2)
    both = casadi.Function("both", [given], [casadi.vertcat(picked(given, 0), picked(given, 1))])
    text = functions_text([both], ())
    first, second = (text.index(f"static void picked_{place}") for place in (0, 1))
    assert "x0[0]" in text[first:second]
    assert "x0[1]" in text[second:]


@as_c_function
def told_apart(given: Number, by: object) -> Number:
    return 2.0 * given if by is True else 3.0 * given


def test_true_is_not_taken_for_one() -> None:
    given = casadi.MX.sym("given")
    both = casadi.Function("both", [given], [told_apart(given, 1), told_apart(given, True)])
    assert [float(each) for each in both(1.0)] == [3.0, 2.0]


@partial(vectorised_pair, paired=1)
def scaled(pair: Pair, factor: Number) -> Pair:
    return Pair(pair.first * factor, pair.second - factor[0])


def test_two_side_by_side_are_a_loop_in_c() -> None:
    both = Pair(np.arange(6.0), np.array([7.0, 8.0]))
    found = scaled(both, np.array([2.0, 3.0, 4.0]))
    assert found.first.tolist() == [0, 2, 6, 9, 16, 20]
    assert found.second.tolist() == [5, 6]
    first, second, factor = (casadi.MX.sym(name, size) for name, size in (("a", 6), ("b", 2), ("c", 3)))
    graph = casadi.Function("graph", [first, second, factor], list(scaled(Pair(first, second), factor)))
    for one, other in zip(graph(*both, [2.0, 3.0, 4.0]), found, strict=True):
        assert one.full().ravel().tolist() == other.tolist()
    text = functions_text([graph], ())
    assert "for (int i=0; i<2; ++i) {" in text
    assert "y0[4+i]=" in text

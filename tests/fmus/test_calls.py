"""Functions that the generated C calls, and those that it skips while they change nothing."""

from typing import NamedTuple

import casadi
import pytest

from warmlink.fmus.calls import idle_at_zero, kept_whole
from warmlink.fmus.component.arithmetic import Number
from warmlink.fmus.packaging.native.casadi_code import functions_text
from warmlink.fmus.packaging.native.lanes import in_lanes


class Pair(NamedTuple):
    first: Number
    second: Number


@idle_at_zero
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
    text = functions_text("idle", [graph()], ())
    assert text.count("/* moved_run:") == text.count("/* moved_skip:") == 1
    assert "if (any_of(*arg[0]))" in in_lanes(text, 4), "side by side it runs where any run needs it"


@kept_whole
def picked(given: Number, place: int) -> Number:
    return 2.0 * given[place]


def test_what_differs_by_a_whole_number_is_another_function() -> None:
    given = casadi.MX.sym("given", 2)
    both = casadi.Function("both", [given], [casadi.vertcat(picked(given, 0), picked(given, 1))])
    text = functions_text("both", [both], ())
    first, second = (text.index(f"/* picked_{place}:") for place in (0, 1))
    assert "x0[0]" in text[first:second]
    assert "x0[1]" in text[second:]

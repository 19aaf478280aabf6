"""What is remembered of a law is what it computed: matrices, choices, and what is refused."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from warmlink.controllers.export.program import tracing
from warmlink.controllers.export.program.algebra import apply, told_by
from warmlink.controllers.export.program.noted import Noted
from warmlink.controllers.export.program.ranges import never_negative, never_zero
from warmlink.controllers.export.program.tracing import leaf
from warmlink.controllers.kalman import carried_over, variance_along
from warmlink.controllers.matrices import blocks, diagonal, dot, matrix, outer, symmetric, upper
from warmlink.fmus.component.arithmetic import (
    absolute,
    beside,
    clip,
    erf,
    exp,
    maximum,
    placed,
    side,
    stack,
    total,
    truth,
    where,
)
from warmlink.fmus.errors import InputError

A, B = np.array([1.5, -2.0, 0.25]), np.array([-1.0, 3.0, 4.0])
PACKED = np.array([4.0, 1.0, 0.5, 3.0, -0.25, 2.0])

CASES: dict[str, Callable[[Any, Any, Any], Any]] = {
    "a product with a matrix": lambda a, b, p: symmetric(p, 3) @ a,
    "a row and a matrix": lambda a, b, p: a @ symmetric(p, 3),
    "two matrices": lambda a, b, p: symmetric(p, 3) @ outer(a, b),
    "a transpose": lambda a, b, p: matrix(p, 2).T @ a[:2],
    "a diagonal matrix": lambda a, b, p: upper(diagonal(a) @ symmetric(p, 3) @ diagonal(a).T),
    "blocks": lambda a, b, p: upper(
        blocks(diagonal(a), outer(a, b[:2]), diagonal(b[:2]))
        @ blocks(symmetric(p, 3), outer(a, b[:2]), diagonal(b[:2]))
    ),
    "a covariance": lambda a, b, p: carried_over(p, outer(a, b) + diagonal(b)),
    "a variance": lambda a, b, p: variance_along(p, a),
    "a choice": lambda a, b, p: where(a > b, a, 0.0 * b) + where(absolute(a) <= 1.5, 1.0, 2.0),
    "a sign that is turned below a limit": lambda a, b, p: where(a < 1.0, -a, a),
    "flags": lambda a, b, p: truth(a > 0) * (1.0 - truth(b > 0)) + maximum(truth(a > 1), truth(b > 1)),
    "bounds": lambda a, b, p: clip(a, -1.0, 1.0) + maximum(0.0, b),
    "numbers side by side": lambda a, b, p: side(1, beside(a, b)) - side(0, beside(a, b)),
    "a stack": lambda a, b, p: stack(a[1], b[::-1], 0.0, placed(a[0], 1, 3)),
    "sums": lambda a, b, p: stack(total(a), dot(a, b), total(truth(a > 0))),
    "sums of a matrix": lambda a, b, p: stack(
        np.sum(outer(a, b)), outer(a, b[:2]).sum(), np.sum(outer(a, b), axis=0), outer(a, b).sum(axis=1)
    ),
    "matrices below each other": lambda a, b, p: np.concatenate([outer(a, b), symmetric(p, 3)]) @ a,
    "functions": lambda a, b, p: exp(-a) + erf(b[0]) + a**2 + absolute(b) ** 0.5,
}


@pytest.mark.parametrize("name", CASES)
def test_it_computes_what_numpy_does(name: str) -> None:
    function = CASES[name]
    with tracing.traced(Noted):
        given = [
            leaf("design", each, value.shape, value)
            for each, value in zip("abp", (A, B, PACKED), strict=True)
        ]
        found = function(*given)
    assert isinstance(found, Noted)
    np.testing.assert_allclose(found.value, np.asarray(function(A, B, PACKED), dtype=float), rtol=1e-14)


def test_a_flag_is_known_for_one_and_is_a_condition_again() -> None:
    with tracing.traced(Noted):
        x = leaf("state", "x", ())
        warm = truth(x > 300.0)
        both = warm * truth(x < 400.0)
        assert told_by(both) is not None
        assert (both > 0).kind == "and"
        assert ((1.0 - warm) > 0).kind == "not"
        assert where(warm > 0, 1.0, 0.0) is warm
        assert warm * warm is warm


def test_divisions_are_guarded_unless_nothing_can_make_them_zero() -> None:
    with tracing.traced(Noted):
        x, std = leaf("state", "x", ()), leaf("design", "std", (), np.array(0.1))
        assert never_zero(x**2 + std**2)
        assert never_zero(maximum(x, 1e-3))
        assert not never_zero(x)
        assert not never_zero(x**2)
        assert never_negative(x**2)
        assert not never_negative(apply("sub", x, 1.0))


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda x: 1.0 if x > 0 else 0.0, "decides with where"),
        (lambda x: float(x), "functions of warmlink"),
        (lambda x: np.sort(x), "numpy.sort in a law cannot be exported"),
        (lambda x: np.where(x > 0), "numpy.where in a law cannot be exported"),
        (lambda x: np.sum(x, keepdims=True), "numpy.sum in a law cannot be exported"),
        (lambda x: np.add.reduce(x, initial=1.0), "numpy.add in a law cannot be exported"),
        (lambda x: np.arctan(x), "numpy.arctan in a law cannot be exported"),
    ],
)
def test_what_cannot_be_written_down_is_refused(wrong: Callable[[Any], Any], said: str) -> None:
    with tracing.traced(Noted), pytest.raises(InputError, match=said):
        wrong(leaf("state", "x", (3,)) if said.startswith("numpy.sort") else leaf("state", "x", ()))

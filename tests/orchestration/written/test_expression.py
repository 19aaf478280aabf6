"""Expressions that a scenario scores by."""

import contextlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from warmlink.fmus.errors import InputError
from warmlink.orchestration.written.expression import Expression

VALUES = {
    "a.link.elongation": np.array([1.0, 4.0]),
    "law.correction": np.array([0.5, 1.0]),
    "k.error[2]": np.array([9.0, 16.0]),
}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a.link.elongation - law.correction", [0.5, 3.0]),
        ("2 * (a.link.elongation + 1) / 4", [1.0, 2.5]),
        ("-sqrt(k.error[2])", [-3.0, -4.0]),
        ("abs(law.correction - a.link.elongation) ** 2", [0.25, 9.0]),
    ],
)
def test_value(text: str, expected: list[float]) -> None:
    assert Expression(text).value(VALUES.__getitem__) == pytest.approx(expected)


def test_a_division_by_zero_gives_no_number_and_no_crash() -> None:
    assert np.isnan(Expression("0 / 0").value(VALUES.__getitem__))
    assert Expression("a.x / 0").value({"a.x": 1.0}.__getitem__) == np.inf


def test_variables_come_once_in_their_order() -> None:
    assert Expression("b.y + a.x[3] - b.y").variables == ("b.y", "a.x[3]")


def test_weights_of_a_weighted_sum() -> None:
    assert Expression("a.x + 2 * b.y - c.z / 4").weights() == {"a.x": 1.0, "b.y": 2.0, "c.z": -0.25}


@pytest.mark.parametrize(
    "text",
    [
        *("a.x * b.y", "a.x + 1", "a.x + 1e-9", "abs(a.x - b.y)", "sqrt(a.x)", "sqrt(a.x ** 2)"),
        *("abs(a.x)", "2 * a.x - abs(b.y)", "abs(a.x + b.y)", "abs(a.x - 1000) + a.x - 1000"),
    ],
)
def test_what_is_not_linear_has_no_weights(text: str) -> None:
    with pytest.raises(InputError, match="is not linear"):
        Expression(text).weights()


@pytest.mark.parametrize(
    "text",
    [
        "",
        "elongation",
        "a.x +",
        "a.x if b.y else 0",
        "__import__('os').system('x')",
        "a.f(1)",
        "a.x[b]",
        "'a'",
        "(" * 500 + "a.x" + ")" * 500,
        "a.x + " * 5000 + "a.x",
        "True",
        "-" * 1900 + "a.x",
        "1" * 400,
    ],
)
def test_what_is_no_expression_is_refused_in_a_sentence(text: str) -> None:
    with pytest.raises(InputError, match=r"^score: ") as refused:
        Expression(text)
    assert "\n" not in str(refused.value)


@given(st.text(max_size=60))
def test_any_text_is_read_or_refused(text: str) -> None:
    with contextlib.suppress(InputError):
        Expression(text)

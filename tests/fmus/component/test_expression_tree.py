"""Written expressions worked out from their syntax tree, in numbers."""

from __future__ import annotations

import ast
import math

import pytest

from warmlink.fmus.component.expression import NotAnExpressionError, evaluated

VALUES = {"speed": 3.0, "motor.speed": 2.0, "link.sensor_temperature[2]": 300.0}
FUNCTIONS = {"hypot": (2, math.hypot), "abs": (1, abs)}


def value(text: str) -> float:
    return float(evaluated(ast.parse(text, mode="eval").body, VALUES.__getitem__, FUNCTIONS))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("2 + 3 * 4 - 6 / 4", 12.5),
        ("-speed ** 2", -9.0),
        ("2 ** -1", 0.5),
        ("motor.speed * speed", 6.0),
        ("link.sensor_temperature[2] - 1e2", 200.0),
        ("hypot(3, abs(-4)) + +1", 6.0),
    ],
)
def test_it_is_worked_out(text: str, expected: float) -> None:
    assert value(text) == expected


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("1 + True", "True"),
        ("hypot(3) + 1", "hypot(3)"),
        ("abs(x=1)", "abs(x=1)"),
        ("open('a')", "open('a')"),
        ("2 if speed else 3", "2 if speed else 3"),
        ("speed[0]", "speed[0]"),
        ("(1, 2)", "(1, 2)"),
        ("speed // 2", "speed // 2"),
    ],
)
def test_a_part_that_means_nothing_is_named(text: str, part: str) -> None:
    with pytest.raises(NotAnExpressionError) as wrong:
        value(text)
    assert str(wrong.value) == part

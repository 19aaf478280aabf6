"""Which causes stand in for which, in few words."""

from __future__ import annotations

import pytest

from warmlink.orchestration.diagnosis.answer.separation import differences, stand_ins


def sets(*names: str) -> list[frozenset[str]]:
    return [frozenset(name.split("+")) for name in names]


@pytest.mark.parametrize(
    ("best", "rivals", "told"),
    [
        ("a", [], []),
        ("a", ["b", "c"], [["a", "b", "c"]]),
        ("a+x", ["b+x", "c+x"], [["a", "b", "c"]]),
        ("a+x", ["b+x", "a+y", "b+y"], [["a", "b"], ["x", "y"]]),
        ("a", ["b+c"], [["a", "b+c"]]),
        ("a", ["a+b"], [["a", "a+b"]]),
        # c stands in for b, which is beside y only: two exchanges lead from the best to it.
        ("b+x", ["b+y", "c+y"], [["b", "c"], ["x", "y"]]),
        # Nothing says that b stands in for a or y for x, only for both.
        ("a+x", ["b+y"], [["a+x", "b+y"]]),
    ],
)
def test_exchanges_are_told_once(best: str, rivals: list[str], told: list[list[str]]) -> None:
    assert stand_ins(*sets(best), sets(*rivals)) == told


@pytest.mark.parametrize(
    ("best", "rivals", "told"),
    [
        ("a", [], []),
        ("a+x", ["b+x", "c+x"], [("a", "b"), ("a", "c")]),
        ("a+x", ["b+x", "b+y"], [("a", "b")]),
        ("a+x", ["b+y"], [("a+x", "b+y")]),
        ("a+x", ["a", "a+x+z"], [("x", ""), ("", "z")]),
    ],
)
def test_what_sets_differ_in_is_told_without_what_they_share(
    best: str, rivals: list[str], told: list[tuple[str, str]]
) -> None:
    assert differences(*sets(best), sets(*rivals)) == told

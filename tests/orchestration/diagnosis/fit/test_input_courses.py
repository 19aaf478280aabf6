"""Courses by which what a model leaves may follow an input: itself, its square, and both later."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.fit.patterns import _courses, _varies


def run(times: np.ndarray, **inputs: np.ndarray) -> Any:
    def row_at(at: np.ndarray) -> np.ndarray:
        return np.searchsorted(times, at + 1e-9) - 1

    return cast(Any, SimpleNamespace(inputs=inputs, row_at=row_at))


def test_the_later_course_follows_with_a_time_constant_of_five_minutes() -> None:
    times = np.arange(0.0, 1200.0, 10.0)
    torque = np.where(times < 300.0, 0.0, -4.0)
    found = _courses(run(times, torque=torque), "torque", times)
    on = times >= 300.0
    assert np.unique(found[:, 0]).tolist() == [-1.0, 0.0]
    assert np.unique(found[:, 1]).tolist() == [0.0, 1.0]
    expected = -np.expm1(-(times[on] - 300.0) / 300.0)
    assert found[on, 3] == pytest.approx(expected, abs=1e-12)
    assert found[on, 2] == pytest.approx(-expected, abs=1e-12)


def test_an_input_holds_between_its_rows_and_one_that_was_not_logged_is_none() -> None:
    rows = np.array([0.0, 100.0])
    found = _courses(run(rows, speed=np.array([1.0, 2.0])), "speed", np.array([0.0, 50.0, 100.0, 150.0]))
    assert found[:, 0].tolist() == [0.5, 0.5, 1.0, 1.0]
    assert not _courses(run(rows), "speed", rows).any()


@pytest.mark.parametrize(
    ("values", "varies"), [([2.0, 2.0], False), ([2.0, 2.0 + 1e-12], False), ([0.0, np.nan, 1.0], True)]
)
def test_only_what_changes_can_be_followed(values: list[float], varies: bool) -> None:
    assert _varies(np.array(values)) is varies

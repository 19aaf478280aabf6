"""The points at which slaves communicate."""

from __future__ import annotations

import re

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.run import simulate

from .pairs import assembly, counter

UNEVEN = CommunicationPoints.at([1.0, 2.0, 2.5, 4.0], 1.0, 4.0)


@pytest.mark.parametrize("points", [CommunicationPoints.between(1.0, 7.0, 1.5), UNEVEN])
def test_some_of_the_points_have_the_times_of_all(points: CommunicationPoints) -> None:
    times = [points.time(point) for point in range(points.count + 1)]
    first, rest = points.first(2), points.following(1)
    assert [first.time(point) for point in range(first.count + 1)] == times[:3]
    assert [rest.time(point) for point in range(rest.count + 1)] == times[1:]
    assert [rest.step(point) for point in range(rest.count)] == np.diff(times)[1:].tolist()
    assert points.first(99) == points


@pytest.mark.parametrize(
    ("times", "told"),
    [
        ([], "their times do not rise"),
        ([0.0], "their times do not rise"),
        ([0.0, 1.0, 1.0, 2.0], "their times do not rise"),
        ([0.0, np.nan, 2.0], "their times do not rise"),
        ([0.0, 0.1, 0.2], "they lead from 0 to 0.2 s, and the run from 0 to 2 s"),
        ([1.0, 2.0], "they lead from 1 to 2 s"),
    ],
)
def test_times_that_are_not_those_of_the_run_are_refused(times: list[float], told: str) -> None:
    system = assembly([slave := counter("x")])
    ended: list[str] = []
    slave.terminate = lambda: ended.append(slave.name)  # type: ignore[method-assign]
    with pytest.raises(InputError, match=re.escape(told)):
        simulate(system, 2.0, np.array(times))
    assert ended == ["x"], "an assembly is closed also where it cannot be run"


def test_a_run_at_given_times() -> None:
    result = simulate(assembly([counter("x")]), 4.0, [1.0, 2.0, 2.5, 4.0], start_time=1.0)
    assert result.times.tolist() == [1.0, 2.0, 2.5, 4.0]
    assert result["x.y"].tolist() == [0.0, 1.0, 1.5, 3.0]

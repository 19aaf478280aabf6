"""Cores are timed in turn with what would do their work, and the same work."""

from __future__ import annotations

import pytest

from benchmarks import cores
from benchmarks.cores import Gain, gains, in_turn
from warmlink.fmus.errors import InputError


def test_times_are_those_of_the_rounds_and_of_a_share_of_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter([0.0, 8.0, 8.0, 9.0, 9.0, 13.0, 13.0, 17.0, 17.0, 21.0, 21.0, 23.0])
    monkeypatch.setattr(cores.time, "process_time", lambda: next(clock))
    done: list[str] = []
    found = in_turn("one", "other", lambda: done.append("a"), lambda: done.append("b"), 3, 2.0)
    assert done == list("abababab")
    assert found == Gain("one", "other", 2000.0, 2000.0, 1.0)


@pytest.mark.slow
@pytest.mark.platform
def test_every_core_is_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cores, "STOP", 60.0)
    try:
        found = list(gains(1))
    except InputError as fault:
        pytest.skip(str(fault))
    assert [each.core.partition(":")[0] for each in found][:3] == ["native FMU", "master", "joined run"]
    assert all(each.ms > 0 and each.ratio > 0 for each in found)

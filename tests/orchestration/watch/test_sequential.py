"""Thresholds keep the stated rate of false alarms, and ask for more where the sound part is short."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from warmlink.orchestration.watch.sequential import SETTLED, Limits, Sequential, worked_out

THINGS, DAY = 6, 1440


@pytest.fixture(autouse=True)
def _fewer_days(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warmlink.orchestration.watch.sequential._TICKS", (200_000, 400_000))
    monkeypatch.setattr("warmlink.orchestration.watch.sequential._MACHINES", 96)


def noise(ticks: int, seed: int, memory: float = 0.0) -> np.ndarray:
    """Leanings of so many ticks, white or correlated over some ticks, shape (ticks, things)."""
    draw = np.random.default_rng(seed).standard_normal((ticks, THINGS))
    for k in range(1, ticks if memory else 0):
        draw[k] = memory * draw[k - 1] + np.sqrt(1 - memory**2) * draw[k]
    return draw


@cache
def once_a_month() -> Limits:
    """Limits for one false alarm in thirty days of white leanings."""
    return worked_out(noise(2000, 1), np.ones((2000, THINGS)), rate=1 / 30, day=DAY)


def alarms(limits: Limits, lean: np.ndarray) -> int:
    """Times at which a test goes from silence into an alarm, an hour apart at least."""
    test, quiet, found = Sequential(limits, THINGS), 60, 0
    for row in lean:
        above = test.add(row, np.ones(THINGS)).max() >= 1
        found += bool(above and quiet >= 60)
        quiet = 0 if above else quiet + 1
    return found


@pytest.mark.parametrize("memory", [0.0, 0.7])
def test_the_stated_rate_of_false_alarms_is_kept(memory: float) -> None:
    """Also of innovations that a missing part of the model has made alike from tick to tick."""
    limits = worked_out(noise(2000, 1, memory), np.ones((2000, THINGS)), rate=1.0, day=DAY)
    found = alarms(limits, noise(int(12 * DAY), 2, memory))
    assert found <= 12 + 3 * np.sqrt(12)


def test_what_leans_is_found() -> None:
    limits = once_a_month()
    test, lean = Sequential(limits, THINGS), noise(400, 3)
    lean[200:, 4] += 2.0
    levels = np.array([test.add(row, np.ones(THINGS)).copy() for row in lean])
    first = int(np.argmax(levels.max(axis=1) >= 1))
    assert 200 < first < 240
    assert int(np.argmax(levels[first])) == 4


def test_an_alarm_of_a_loud_fault_lasts_no_longer_after_it_than_that_of_a_faint_one() -> None:
    """And what comes later is found again."""
    limits = once_a_month()
    lasted = []
    for loud in (2.0, 20.0):
        test, lean = Sequential(limits, THINGS), 0.1 * noise(900, 3)
        lean[200:240, 4] += loud
        lean[800:840, 4] += loud
        above = np.array([test.add(row, np.ones(THINGS)).max() >= 0.7 for row in lean])
        assert np.all(above[235:240])
        assert np.all(above[835:840])
        lasted.append(int(above[240:800].sum()))
    assert 0 < lasted[0] == lasted[1]


def test_a_short_sound_part_and_a_smaller_rate_ask_for_more_evidence() -> None:
    long, short = (worked_out(noise(n, 1), np.ones((n, THINGS)), 1 / 30, DAY) for n in (3000, 200))
    assert (short.threshold * short.sizes).min() > (long.threshold * long.sizes).max()
    assert "only 10 blocks" in short.told()
    assert short.memories == (10, 60), "an hour needs three of sound log"
    rare = worked_out(noise(3000, 1), np.ones((3000, THINGS)), 1 / 3000, DAY)
    assert (rare.threshold * rare.sizes).mean() > (long.threshold * long.sizes).mean()
    assert rare.extrapolated
    assert "tail" in rare.told()


def test_the_same_sound_part_gives_the_same_thresholds() -> None:
    one, other = (worked_out(noise(500, 1), np.ones((500, THINGS)), 1 / 30, DAY) for _ in range(2))
    assert one.threshold == other.threshold
    assert np.array_equal(one.sizes, other.sizes)


def test_a_gap_ends_what_the_test_says_until_the_filter_has_settled() -> None:
    """What was mended during the gap stood for half an hour after it."""
    limits = once_a_month()
    test = Sequential(limits, THINGS)
    for row in noise(200, 3) + 3.0:
        test.add(row, np.ones(THINGS))
    assert test.level.max() >= 1
    test.begin()
    assert [test.add(np.zeros(THINGS), np.ones(THINGS)).max() for _ in range(SETTLED)] == [0.0] * SETTLED


def test_more_alarms_than_a_stretch_has_ticks_are_no_fault() -> None:
    limits = worked_out(noise(500, 1), np.ones((500, THINGS)), rate=500.0, day=DAY)
    assert np.isfinite(limits.threshold)
    assert limits.threshold > 0

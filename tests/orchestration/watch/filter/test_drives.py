"""Lags of what drives a machine: steps, ticks of any length, and a machine that stands."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from warmlink.orchestration.watch.filter.drives import LAGS, Drives
from warmlink.orchestration.watch.ticks import Tick

NONE = np.zeros(0)
ROOM = 295.15
INPUTS = ("speed", "torque", "room")
RIG: Any = SimpleNamespace(
    unit={"speed": "rad/s", "torque": "N.m", "room": "K"}.__getitem__,
    externals=("room", "speed", "torque"),
    variables={"room": SimpleNamespace(start=ROOM), "speed": SimpleNamespace(start=0.0)},
)


def tick(start: float, end: float, *levels: tuple[float, float, float], shares: Any = (1.0,)) -> Tick:
    """A tick in which room [K], speed and torque had these levels."""
    return Tick(start, end, np.array(levels), np.array(shares), NONE, NONE, NONE, NONE, 0.0, False)


def drives() -> Drives:
    return Drives(cast(Any, RIG), INPUTS, 60.0)


WORK = (ROOM + 5.0, -3.0, 10.0)
FEATURES = np.array([3.0, 10.0, 9.0, 100.0, 30.0, 5.0])
"""Sizes, squares and product of speed and torque, and how warm the room is, at `WORK`."""


def test_a_machine_that_stood_for_long_has_the_room_s_temperature_alone() -> None:
    lags = drives().begin(tick(0.0, 60.0, WORK))
    count = len(LAGS)
    np.testing.assert_allclose(lags.reshape(count, -1), np.tile([0, 0, 0, 0, 0, 5.0], (count, 1)))


def test_each_lag_follows_a_step_with_its_time_constant() -> None:
    made, time = drives(), 1200.0
    lags = made.onward(np.zeros(made.size), tick(0.0, time, WORK))
    for row, ticks in zip(lags.reshape(len(LAGS), -1), LAGS, strict=True):
        np.testing.assert_allclose(row, FEATURES * -np.expm1(-time / (60.0 * ticks)), rtol=1e-12)


def test_two_short_ticks_are_a_long_one_and_levels_count_by_their_shares() -> None:
    made = drives()
    whole = made.onward(np.zeros(made.size), tick(0.0, 90.0, WORK))
    first = made.onward(np.zeros(made.size), tick(0.0, 30.0, WORK))
    np.testing.assert_allclose(made.onward(first, tick(30.0, 90.0, WORK)), whole, rtol=1e-12)
    idle = (ROOM, 0.0, 0.0)
    half = made.onward(np.zeros(made.size), tick(0.0, 90.0, WORK, idle, shares=(0.5, 0.5)))
    np.testing.assert_allclose(half, whole / 2, rtol=1e-12)


def test_work_is_stirred_where_it_is_not_what_it_was_and_the_more_the_harder_it_is() -> None:
    made, idle, before = drives(), (ROOM + 5.0, 0.0, 0.0), tick(0.0, 60.0, WORK)
    usual, cold = made.usual([before]), made.begin(before)
    np.testing.assert_allclose(usual, FEATURES[:-1])
    np.testing.assert_allclose(made.stirred(cold, before, usual), 1.0)
    np.testing.assert_allclose(made.stirred(cold, tick(0.0, 60.0, idle), usual), 0.0)
    warm = made.onward(cold, tick(0.0, 1e9, WORK))
    np.testing.assert_allclose(made.stirred(warm, before, usual), 0.0, atol=1e-9)
    np.testing.assert_allclose(made.stirred(warm, tick(0.0, 60.0, idle), usual), 1.0)
    harder = tick(0.0, 60.0, (ROOM + 5.0, 6.0, 20.0))
    np.testing.assert_allclose(made.stirred(cold, harder, usual), (2 * 2**2 + 3 * 4**2) / 5)
    never = made.stirred(cold, harder, np.zeros(5))
    assert np.all(np.isfinite(never))
    assert np.all(never > 10)


def test_without_a_drive_that_is_logged_work_is_never_stirred() -> None:
    made, now = Drives(cast(Any, RIG), ("room",), 60.0), tick(0.0, 60.0, WORK)
    assert np.all(made.stirred(made.begin(now), now, made.usual([now])) == 0.0)

"""Leaps of thermometers are added up until they leap back, and nothing else is."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.controllers import leaps
from warmlink.controllers.fail_safe import FASTEST, Trust
from warmlink.controllers.interface import SENSED

COUNT, STEP, GATE, STD = len(SENSED), 1.0, 4.0, 0.1
NOISE = 2.0**0.5 * GATE * STD


def heard(*readings: Any, std: float = STD, out_from: int = 99) -> list[float]:
    """What the first thermometer has leapt after each reading in K; the others stay as they are.

    From a reading on, by its number, it is left out.
    """
    p = SimpleNamespace(gate=GATE, sensor_std=np.full(COUNT, std))
    x, last, found = SimpleNamespace(**leaps.none(np.full(COUNT, 300.0))), np.full(COUNT, 300.0), []
    for number, reading in enumerate(readings):
        now = np.full(COUNT, 300.0)
        now[0] = reading
        zero = np.zeros(COUNT)
        left_out = np.append(float(number >= out_from), zero[1:])
        x = SimpleNamespace(**leaps.later(x, now, Trust(last, zero, zero, zero, left_out), p, STEP))
        last = np.where(np.isfinite(now), now, last)
        found.append(float(x.leapt[0]))
        assert not np.any(x.leapt[1:])
        assert float(leaps.leapt(x)) == (found[-1] != 0)
    return found


def test_what_heat_can_do_is_no_leap() -> None:
    fastest = NOISE + FASTEST * STEP
    assert heard(300.0 + 0.999 * fastest) == [0.0]
    assert heard(300.0 + 1.001 * fastest) == [pytest.approx(1.001 * fastest)]


def test_a_leap_is_kept_until_the_thermometer_leaps_back() -> None:
    assert heard(320.0, 320.1, 320.0, 300.05) == pytest.approx([20.0, 20.0, 20.0, 0.0], abs=NOISE)
    assert heard(320.0, 300.05)[-1] == 0.0
    assert heard(320.0, 310.0, 300.0) == pytest.approx([20.0, 10.0, 0.0])


def test_after_silence_heat_may_have_done_more() -> None:
    nothing = float("nan")
    change = NOISE + 4.5 * FASTEST * STEP
    assert heard(*[nothing] * 3, 300.0 + change) == [0.0, 0.0, 0.0, pytest.approx(change)]
    assert heard(*[nothing] * 5, 300.0 + change)[-1] == 0.0


def test_one_that_is_not_there_or_left_out_does_not_count_but_may_return() -> None:
    assert heard(320.0, std=0.0) == [0.0]
    assert heard(320.0, out_from=0) == [0.0]
    assert heard(320.0, 300.05, out_from=1) == pytest.approx([20.0, 0.0])


def test_one_that_leaps_again_when_it_is_left_out_may_return_from_there() -> None:
    assert heard(320.0, 340.0, 300.05, out_from=1)[-1] == 0.0

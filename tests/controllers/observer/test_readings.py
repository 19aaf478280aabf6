"""Thermometers beside what the duty explains: what looks like heat, like a shift, like one that is wrong."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.controllers.fail_safe import FASTEST, Trust
from warmlink.controllers.matrices import matrix
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer.model import SENSORS, BelievedDuty
from warmlink.controllers.observer.readings import SMOOTHING, Compared, compared, cools, extremes, shape_of

P: Any = OBSERVER.d.read(np.asarray(OBSERVER.settled(OBSERVER.start_values()[0])))
ROOM, STEP = 295.15, 1.0
ALL = np.ones(SENSORS)
HEAT = [10.0, 10.0, 6.0, 4.0, 3.0]
"""K above the duty at shaft, winding, base, middle and tip, where heat comes from the shaft."""

SLOWEST = np.asarray(matrix(P.sensor_rows, SENSORS)[:, 0])


def beside(excess: Any, called: Any = ALL, rise: Any = 0.0) -> Compared:
    """Readings that lie so far above what the duty explains, and have done so for long."""
    excess, called, none = np.asarray(excess, dtype=float), np.asarray(called), np.zeros(SENSORS)
    return Compared(none, excess, none + rise, excess, called, called, called, float(excess.min()), 1.0)


def without(*numbers: int) -> Any:
    return np.where(np.isin(np.arange(SENSORS), numbers), 0.0, 1.0)


@pytest.mark.parametrize(
    ("excess", "called", "heated", "falls"),
    [
        (HEAT, ALL, 0.0, 1.0),
        ([5.0] * SENSORS, ALL, 0.0, 0.0),
        ([10.0, 0.0, 0.0, 0.0, 0.0], ALL, 0.0, 0.0),
        ([0.0, 0.0, 0.0, 0.0, 10.0], ALL, 0.0, 0.0),
        ([*HEAT[:4], 10.0], ALL, 0.0, 0.0),
        ([*HEAT[:4], 10.0], without(4), 0.0, 1.0),
        ([10.0, 10.0, 3.0, 2.0, 1.5], ALL, 0.0, 0.0),
        ([10.0, 10.0, 3.0, 2.0, 1.5], ALL, 1.0, 1.0),
    ],
    ids=[
        "heat",
        "a shift of all",
        "the shaft alone",
        "the tip alone",
        "the tip beside heat",
        "the same unheard",
        "heat that reaches too little",
        "a pad's may reach less",
    ],
)
def test_heat_falls_from_the_shaft_outwards_and_reaches_out(
    excess: Any, called: Any, heated: float, falls: float
) -> None:
    assert float(shape_of(beside(excess, called), 1.0, 0.0, heated, P).falls) == falls


@pytest.mark.parametrize("shift", [5.0, -5.0])
def test_a_shift_of_all_is_what_neighbours_show_alike(shift: float) -> None:
    assert float(shape_of(beside([shift] * SENSORS), 1.0, 0.0, 0.0, P).alike) == pytest.approx(5.0)
    assert float(shape_of(beside([shift] * SENSORS), 0.0, 0.0, 0.0, P).alike) == 0.0
    assert float(shape_of(beside(HEAT), 1.0, 0.0, 0.0, P).alike) == 0.0


def test_a_base_as_warm_as_the_winding_should_be_is_no_heat_at_first() -> None:
    """Somebody may have swapped the two."""
    rise = np.array([HEAT[2], 12.0, 6.0, 3.0, 2.0])
    for early, falls in ((0.0, 1.0), (1.0, 0.0)):
        assert float(shape_of(beside(HEAT, rise=rise), 1.0, early, 0.0, P).falls) == falls
    far = rise + np.array([0.0, 10.0, 0.0, 0.0, 0.0])
    assert float(shape_of(beside(HEAT, rise=far), 1.0, 1.0, 0.0, P).falls) == 1.0


@pytest.mark.parametrize(
    ("excess", "left_warm"),
    [
        (20.0 * SLOWEST / SLOWEST[0], 1.0),
        (np.full(SENSORS, 5.0), 0.0),
        (np.array([5.0, 0.0, 0.0, 0.0, 0.0]), 0.0),
        (-20.0 * SLOWEST / SLOWEST[0], 0.0),
        (20.0 * SLOWEST / SLOWEST[0] + np.array([0.0, 0.0, 5.0, 0.0, 0.0]), 0.0),
    ],
    ids=["the slowest mode", "a shift of all", "one alone", "colder than the room", "an outer one warmest"],
)
def test_a_cell_that_was_left_warm_looks_like_its_slowest_mode(excess: Any, left_warm: float) -> None:
    assert float(cools(beside(excess), P)) == left_warm


def test_extremes_are_of_what_is_there() -> None:
    values = np.array([3.0, -7.0, 5.0, 9.0, 1.0])
    assert [float(each) for each in extremes(values, without(1, 3))] == [5.0, 1.0]
    assert [float(each) for each in extremes(-values, without(1, 3))] == [-1.0, -5.0]
    assert [float(each) for each in extremes(values, 0.0 * ALL)] == [0.0, 0.0]


def after(readings: Any, out: Any = 0.0, expected: float = ROOM) -> Compared:
    x = SimpleNamespace(seen=np.full(SENSORS, ROOM), lagged=np.zeros(SENSORS))
    zero = np.zeros(SENSORS)
    trust = Trust(zero, zero, zero, zero, zero + out)
    return compared(
        x, zero + expected, np.asarray(readings), trust, BelievedDuty(0.0, 0.0, ROOM - 1.0), P, STEP
    )


def test_readings_are_smoothed_leap_no_faster_than_heat_does_and_may_be_missing() -> None:
    found = after([ROOM + 0.1, ROOM + 50.0, ROOM - 50.0, np.nan, ROOM])
    slow = 0.1 * STEP / (STEP + SMOOTHING)
    moved = [slow, FASTEST * STEP, -FASTEST * STEP, 0.0, 0.0]
    assert found.seen - ROOM == pytest.approx(moved, abs=1e-9)
    assert found.rise == pytest.approx(np.ones(SENSORS))


def test_one_that_is_missing_is_off_by_nothing() -> None:
    used = np.asarray(P.sensor_std) > 0
    one = int(np.flatnonzero(used)[0])
    even = np.full(SENSORS, ROOM)
    found = after(np.where(without(one) > 0, even, np.nan), expected=ROOM - 4.0)
    assert found.there.tolist() == (used & (without(one) > 0)).tolist()
    assert found.excess == pytest.approx(4.0 * used * without(one))
    assert [float(found.whole), float(after(even).whole)] == [0.0, 1.0]


def test_those_left_out_are_heard_where_all_are_off_alike_or_none_is_left() -> None:
    one = int(np.flatnonzero(np.asarray(P.sensor_std) > 0)[0])
    first = 1.0 - without(one)
    even = np.full(SENSORS, ROOM)
    assert after(even, first).called[one] == 1.0
    x = SimpleNamespace(seen=even + 5.0 * first, lagged=np.zeros(SENSORS))
    zero = np.zeros(SENSORS)

    def heard(out: Any) -> Any:
        trust = Trust(zero, zero, zero, zero, out)
        return compared(x, even, x.seen, trust, BelievedDuty(0.0, 0.0, ROOM), P, STEP).called

    assert heard(first)[one] == 0.0
    assert heard(np.ones(SENSORS))[one] == 1.0
    x.seen = even - 10.0 - first
    assert heard(first)[one] == 1.0

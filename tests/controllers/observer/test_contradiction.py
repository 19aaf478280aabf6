"""Sensors that contradict the duty: which is left out, and from what the alert filter begins again."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.controllers.fail_safe import Trust
from warmlink.controllers.kalman import Belief
from warmlink.controllers.matrices import symmetric, upper
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer.contradiction import WILD, Examined, examined, reconciled
from warmlink.controllers.observer.filters import Filters, together
from warmlink.controllers.observer.model import HEATS, MODES, SENSORS, STATES, BelievedDuty, temperatures

P: Any = OBSERVER.d.read(np.asarray(OBSERVER.settled(OBSERVER.start_values()[0])))
USED = np.flatnonzero(np.asarray(P.sensor_std) > 0)
ROOM = float(P.linearisation_temperature)
STILL = BelievedDuty(0.0, 0.0, ROOM)


def filters(heat: float = 0.0, wild: float = 0.0) -> Filters:
    """Filters that believe in so many watts of unknown heat in the link, and in modes of this size."""
    mean = np.zeros(STATES)
    mean[0], mean[MODES + 1] = wild, heat
    sure = upper(np.diag(np.full(STATES, 1e-6)))
    return together(Belief(mean, sure, sure), Belief(0.5 * mean, sure, sure))


def trust(out: Any = 0.0) -> Trust:
    zero = np.zeros(SENSORS)
    return Trust(zero, zero, zero, np.full(SENSORS, 7.0), zero + out)


def said(too_much: float = 0.0, wild: float = 0.0) -> Examined:
    """What an examination may say of a cell whose duty says that all is as warm as the room."""
    return Examined(wild, np.zeros(MODES), temperatures(np.zeros(MODES), P), 0.0, 1.0, too_much)


def judged(what: Examined, readings: Any, before: Filters | None = None, out: Any = 0.0) -> Any:
    surroundings = SimpleNamespace(ambient_temperature=ROOM)
    return reconciled(before or filters(5.0), trust(out), np.asarray(readings), what, surroundings, P)


def read(**away: float) -> Any:
    """Readings at room temperature but for some sensors, by number, so many kelvins away."""
    values = np.full(SENSORS, ROOM)
    for name, value in away.items():
        values[int(name.removeprefix("s"))] += value
    return values


def test_where_nothing_contradicts_all_stays() -> None:
    before = filters(5.0)
    after, kept, begins = judged(said(), read(), before)
    assert float(begins) == 0
    assert all(np.array_equal(a, b) for a, b in zip(after, before, strict=True))
    assert np.array_equal(kept.out, np.zeros(SENSORS))
    assert np.array_equal(kept.calm_for, np.full(SENSORS, 7.0))


def test_the_sensor_farthest_from_the_duty_is_left_out_and_all_begins_from_the_duty() -> None:
    wrong = int(USED[0])
    after, kept, begins = judged(said(too_much=1.0), read(**{f"s{wrong}": 15.0}))
    assert float(begins) == 1
    assert np.flatnonzero(kept.out).tolist() == [wrong]
    assert kept.calm_for[wrong] == 0
    assert np.array_equal(after.alert.mean, np.zeros(STATES))
    again, designed = symmetric(after.alert.spread, STATES), np.asarray(P.disturbance_std[:HEATS]) ** 2
    assert np.linalg.eigvalsh(again).min() > 0
    assert np.diag(again)[MODES:] == pytest.approx(designed)
    warm = symmetric(P.warm_spread, MODES) * 15.0**2
    assert np.all(np.diag(again)[:MODES] >= np.diag(warm))
    assert np.array_equal(after.quiet.mean, filters(5.0).quiet.mean)


def test_each_sensor_that_contradicts_is_left_out_and_the_farthest_if_none_is_far() -> None:
    away = {f"s{i}": 10.0 + i for i in USED}
    assert np.flatnonzero(judged(said(too_much=1.0), read(**away))[1].out).tolist() == USED.tolist()
    near = {f"s{i}": 0.02 * (k + 1) for k, i in enumerate(USED)}
    assert np.flatnonzero(judged(said(too_much=1.0), read(**near))[1].out).tolist() == [USED[-1]]


def test_one_that_is_gone_or_left_out_already_is_not_the_farthest() -> None:
    first, last = int(USED[0]), int(USED[-1])
    gone = read(**{f"s{first}": np.nan, f"s{last}": 5.0})
    assert np.flatnonzero(judged(said(too_much=1.0), gone)[1].out).tolist() == [last]
    already = np.arange(SENSORS) == first
    far = read(**{f"s{first}": 50.0, f"s{last}": 0.05})
    assert np.flatnonzero(judged(said(too_much=1.0), far, out=already)[1].out).tolist() == [first, last]


def test_a_wild_estimate_begins_again_and_leaves_no_sensor_out() -> None:
    after, kept, begins = judged(said(wild=1.0), read(), filters(wild=2 * WILD))
    assert float(begins) == 1
    assert not kept.out.any()
    assert np.array_equal(after.alert.mean, np.zeros(STATES))


@pytest.mark.parametrize(("size", "wild"), [(0.99 * WILD, 0.0), (1.01 * WILD, 1.0), (np.nan, 1.0)])
def test_estimates_beyond_any_temperature_are_wild(size: float, wild: float) -> None:
    found = examined(filters(wild=size), np.zeros(MODES), 0.0, STILL, P)
    assert float(found.wild) == wild
    assert found.expected == pytest.approx(np.full(SENSORS, ROOM))


def test_more_heat_than_a_wrong_model_explains_is_too_much_and_what_was_plausible_fades() -> None:
    hot = examined(filters(heat=40.0), np.zeros(MODES), 0.0, STILL, P)
    assert float(hot.too_much) == 1
    assert float(examined(filters(heat=40.0), np.zeros(MODES), 1e3, STILL, P).too_much) == 0
    assert float(hot.own_heat) == 0
    later = examined(filters(), np.zeros(MODES), 100.0, STILL, P)
    assert float(later.plausible) == pytest.approx(100.0 * P.fade[1])

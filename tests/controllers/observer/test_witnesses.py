"""How far a correction may go by what duty, thermometers and a camera say, and since when all agree."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.controllers.kalman import Belief
from warmlink.controllers.matrices import upper
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer.filters import Filters, together
from warmlink.controllers.observer.model import BASE, MODES, SENSORS, STATES, elongation
from warmlink.controllers.observer.readings import Compared
from warmlink.controllers.observer.witnesses import (
    AGREEMENT_TIME,
    COLD_TIME,
    KNOWN_TIME,
    MARGIN,
    WARM_TIME,
    Look,
    Verdict,
    heard,
)

P: Any = OBSERVER.d.read(np.asarray(OBSERVER.settled(OBSERVER.start_values()[0])))
NONE = np.zeros(SENSORS)
USED = np.where(np.asarray(P.sensor_std) > 0, 1.0, 0.0)
STEP = 1.0
BOUND = MARGIN * float(P.tolerance)
"""m by which a witness may be off at least."""


def modes_for(growth: float) -> Any:
    """Modes that make so many m of elongation."""
    modes = np.asarray(P.elongation_row) / float(np.dot(P.elongation_row, P.elongation_row))
    return modes * (growth - float(elongation(np.zeros(MODES), P)))


FILTERS: Filters = together(
    *2 * [Belief(np.linspace(1.0, 2.0, STATES), *2 * [upper(np.eye(STATES))])],
)


def told(
    duty: float,
    estimate: float,
    excess: Any = 0.0,
    there: Any = USED,
    rise: Any = 0.0,
    known_for: float = KNOWN_TIME,
    agreed_for: float = 2 * AGREEMENT_TIME,
    waited: float = WARM_TIME,
    camera: Look | None = None,
    p: Any = P,
) -> Verdict:
    """The verdict on an estimate in m where the duty makes so many m, and readings lie so many K beyond."""
    excess = np.where(there, np.zeros(SENSORS) + excess, 0.0)
    least = float(excess[there > 0].min()) if there.any() else 0.0
    whole = float(np.array_equal(there, np.asarray(p.sensor_std) > 0))
    sensors = Compared(NONE, excess, NONE + rise, excess, there, there, there, least, whole)
    x = SimpleNamespace(known_for=known_for, agreed_for=agreed_for, waited=waited, heated=0.0)
    return heard(x, FILTERS, estimate, modes_for(duty), sensors, p, STEP, camera or Look())


def shift_for(growth: float) -> float:
    """K by which all thermometers are off alike, which no heat does, that makes so many m."""
    return growth / float(np.sum(P.growth_by_all))


@pytest.mark.parametrize("known_for", [KNOWN_TIME, 0.0])
@pytest.mark.parametrize("duty", [-40e-6, -5e-6, 0.0, 5e-6, 40e-6])
@pytest.mark.parametrize("sensed", [-40e-6, -5e-6, 0.0, 5e-6, 40e-6])
def test_whichever_witness_is_right_no_allowed_correction_is_worse_than_none(
    duty: float, sensed: float, known_for: float
) -> None:
    for estimate in (-80e-6, 0.0, 80e-6):
        found = told(duty, estimate, shift_for(sensed - duty), known_for=known_for)
        for bound in (float(found.lower), float(found.upper)):
            for right in (duty, sensed) if known_for else (duty,):
                assert abs(right - bound) <= abs(right) + BOUND * (1 + 1e-9)


def test_witnesses_that_agree_allow_what_all_of_them_say() -> None:
    for growth in (-40e-6, 5e-6, 40e-6):
        found = told(growth, growth)
        assert float(found.lower) <= growth <= float(found.upper)
        assert float(found.disagree) == float(found.doubt) == 0.0


HEAT = np.array([10.0, 10.0, 6.0, 4.0, 3.0])


def test_heat_from_the_shaft_that_has_lasted_may_be_more_than_the_duty_tells() -> None:
    sensed = float(np.dot(P.growth_by_all, HEAT))
    lasting, sudden = (told(0.0, sensed, HEAT, agreed_for=each) for each in (AGREEMENT_TIME, 0.0))
    assert float(lasting.upper) >= sensed
    assert float(sudden.upper) == pytest.approx(BOUND)
    assert float(told(0.0, sensed, HEAT, known_for=0.0).upper) == pytest.approx(BOUND)


@pytest.mark.parametrize("estimate", [60e-6, 0.0])
def test_after_a_disagreement_the_correction_is_in_doubt_until_all_have_agreed_for_long(
    estimate: float,
) -> None:
    for there in (USED, NONE):  # against the thermometers, and against the duty alone
        found = told(30e-6, estimate, there=there)
        assert (float(found.disagree), float(found.agreed_for), float(found.doubt)) == (1.0, 0.0, 1.0)
    almost = told(30e-6, 30e-6, agreed_for=AGREEMENT_TIME - 1.5 * STEP)
    assert (float(almost.disagree), float(almost.doubt)) == (0.0, 1.0)
    assert float(almost.agreed_for) == AGREEMENT_TIME - 0.5 * STEP
    assert float(told(30e-6, 30e-6, agreed_for=AGREEMENT_TIME - STEP).doubt) == 0.0


def test_readings_as_foreseen_show_within_seconds_that_a_cell_started_cold() -> None:
    pace = KNOWN_TIME / COLD_TIME
    begun = {"known_for": 0.0, "waited": 0.0}
    assert float(told(0.0, 0.0, **begun).known_for) == pytest.approx(pace * STEP)
    assert float(told(0.0, 0.0, known_for=KNOWN_TIME - pace * STEP).doubt) == 0.0
    assert (
        float(told(0.0, 0.0, there=np.where(np.arange(SENSORS) == BASE, USED, 0.0), **begun).known_for) == 0.0
    )


def test_readings_that_are_not_as_foreseen_take_back_what_was_known() -> None:
    away = {"excess": [0.0, 0.0, 0.0, 0.0, 20.0], "waited": 40.0}
    assert float(told(0.0, 0.0, known_for=30.0, **away).known_for) == 30.0 - STEP
    assert float(told(0.0, 0.0, known_for=0.5 * STEP, **away).known_for) == 0.0
    assert float(told(0.0, 0.0, known_for=KNOWN_TIME, **away).known_for) == KNOWN_TIME


def test_a_cell_left_warm_is_followed_from_where_the_alert_filter_is() -> None:
    start = {"excess": HEAT, "agreed_for": 0.0}
    found = told(0.0, 20e-6, known_for=KNOWN_TIME - STEP, waited=KNOWN_TIME - STEP, **start)
    assert float(found.warm) == 1.0
    assert np.array_equal(found.duty_modes, FILTERS.alert.mean[:MODES])
    assert float(found.doubt) == 0.0
    late = told(0.0, 20e-6, known_for=KNOWN_TIME - STEP, waited=WARM_TIME, **start)
    assert float(late.warm) == 0.0
    assert np.array_equal(late.duty_modes, modes_for(0.0))


def test_the_longer_readings_look_like_a_cell_left_warm_the_further_the_correction_may_follow() -> None:
    growth = float(np.dot(P.growth_by_all, HEAT))
    reached = [
        float(told(0.0, growth, HEAT, known_for=each, waited=each, agreed_for=0.0).upper)
        for each in (0.0, 20.0, 35.0, 49.0)
    ]
    assert reached[0] == pytest.approx(BOUND)
    assert reached == sorted(reached)
    assert reached[-1] > growth / 2


def test_without_thermometers_three_of_the_slowest_time_constants_pass_first() -> None:
    blind = P._replace(sensor_std=NONE)
    found = told(0.0, 0.0, there=NONE, known_for=0.0, p=blind)
    needed = 3.0 / abs(float(P.mode_rate[0]))
    assert float(found.known_for) == pytest.approx(KNOWN_TIME * STEP / needed)


def test_a_camera_is_followed_as_far_as_duty_or_thermometers_bear_it_out() -> None:
    duty, sensed = 40e-6, 10e-6
    apart = {"excess": shift_for(sensed - duty), "agreed_for": 0.0}
    for seen in (duty, sensed):
        found = told(duty, 25e-6, camera=Look(seen, 1.0), **apart)
        assert (float(found.lower), float(found.upper)) == pytest.approx((seen, seen))
    lately = {**apart, "agreed_for": 2 * AGREEMENT_TIME}
    for seen, when in ((100e-6, apart), (sensed, lately)):
        found = told(duty, 25e-6, camera=Look(seen, 1.0), **when)
        without = told(duty, 25e-6, **when)
        assert (float(found.lower), float(found.upper)) == (float(without.lower), float(without.upper))


def test_duty_and_thermometers_apart_do_not_outvote_a_camera_that_denies_the_filter() -> None:
    duty, sensed, seen = 20e-6, 40e-6, 2e-6
    apart = {"excess": shift_for(sensed - duty)}
    believed = told(duty, 30e-6, camera=Look(seen, 1.0, denies=0.0), **apart)
    denied = told(duty, 30e-6, camera=Look(seen, 1.0, denies=25e-6), **apart)
    assert float(denied.upper) == pytest.approx(1.25 * seen + BOUND)
    assert float(believed.upper) > 2 * float(denied.upper)
    together = told(duty, 20e-6, camera=Look(seen, 1.0, denies=25e-6))
    assert float(together.upper) > 2 * float(denied.upper)

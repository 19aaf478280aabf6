"""What the observer has learnt of offsets outlasts a restart, and tells how far its structure is off."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.controllers.matrices import symmetric, upper
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer.model import MODES, SENSORS, BelievedDuty
from warmlink.controllers.observer.offset import (
    DELAY,
    DELAYED_SHARE,
    KEPT,
    OTHER,
    SHARE,
    contradicted,
    first_states,
    kept,
)

P: Any = OBSERVER.d.read(np.asarray(OBSERVER.settled(OBSERVER.start_values()[0])))
ROOM = float(P.linearisation_temperature)
AT_REST = BelievedDuty(0.0, 0.0, ROOM)
MODES_NOW = np.linspace(1.0, 0.2, MODES)
GROWTH = float(np.dot(P.elongation_row, MODES_NOW) / P.elongation_per_kelvin)

LEARNT = SimpleNamespace(
    leapt=np.array([0.0, 3.0, 0.0, 0.0, -2.0]),
    delayed_growth=4.0,
    shares=np.array([0.1, 0.02, 0.3, -0.05, 0.01, 0.2]),
    shares_spread=upper(np.diag([0.02, 0.001, 0.01])),
)


def begun(valid: float = 1.0, passed: float = 0.0, learnt: Any = LEARNT) -> Any:
    """States after a restart whose readings show what the duty explains and what was learnt."""
    return SimpleNamespace(**first_states(MODES_NOW, MODES_NOW, kept(learnt), valid, passed, AT_REST, P))


def test_what_is_kept_is_what_a_restart_begins_with() -> None:
    assert kept(LEARNT).shape == (KEPT,)
    again = begun()
    assert again.leapt.tolist() == LEARNT.leapt.tolist()
    assert again.shares.tolist() == LEARNT.shares.tolist()
    assert float(again.delayed_growth) == 4.0
    assert symmetric(again.shares_spread, 3)[:2, :2] == pytest.approx(np.diag([0.02, 0.001]))


def test_the_delayed_growth_goes_on_towards_the_growth_while_nobody_looks() -> None:
    halfway = begun(passed=DELAY).delayed_growth
    assert float(halfway) == pytest.approx((4.0 + GROWTH) / 2)
    assert float(begun(valid=0.0).delayed_growth) == pytest.approx(GROWTH)


def test_an_offset_may_have_wandered_meanwhile() -> None:
    hours = 5.0
    spread = [symmetric(begun(passed=3600.0 * each).shares_spread, 3)[2, 2] for each in (0.0, hours)]
    delayed = [float(begun(passed=3600.0 * each).delayed_growth) for each in (0.0, hours)]
    beyond = [float(np.dot([GROWTH, each, 1.0], LEARNT.shares[:3])) ** 2 for each in delayed]
    wandered = (spread[1] - beyond[1]) - (spread[0] - beyond[0])
    assert wandered == pytest.approx(float(P.offset_per_hour) ** 2 * hours)


def test_without_a_memory_it_begins_with_the_prior() -> None:
    none = SimpleNamespace(
        leapt=np.zeros(SENSORS), delayed_growth=0.0, shares=np.zeros(6), shares_spread=np.zeros(6)
    )
    found = symmetric(begun(0.0, learnt=none).shares_spread, 3)
    assert found == pytest.approx(np.diag([SHARE**2, DELAYED_SHARE**2, float(P.offset_std) ** 2]))


@pytest.mark.parametrize(
    ("shares", "told"),
    [
        ([0.0, 0.0, 5.0, 0.0, 0.0, -5.0], 0.0),
        ([OTHER / 2, 0.0, 0.0, 0.0, -OTHER / 2, 0.0], 0.5),
        ([0.0, OTHER, 0.0, 0.0, 0.0, 0.0], 1.0),
        ([3 * OTHER, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0),
    ],
    ids=["an offset", "a small share of both", "a delayed share", "a large share"],
)
def test_shares_of_the_growth_contradict_the_structure_and_offsets_do_not(
    shares: list[float], told: float
) -> None:
    assert float(contradicted(SimpleNamespace(shares=np.array(shares)))) == pytest.approx(told)

"""One sample of the observer's law: what it begins with, how far it moves, and what it says of itself."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from warmlink.controllers.interface import SENSED
from warmlink.controllers.observer import law
from warmlink.controllers.observer.component import COMPONENT
from warmlink.controllers.observer.model import elongation
from warmlink.controllers.observer.witnesses import AGREEMENT_TIME, KNOWN_TIME, MARGIN, WARM_TIME

P: Any = COMPONENT.d.read(np.asarray(COMPONENT.settled(COMPONENT.start_values()[0])))
ROOM, TOLERANCE = float(P.reference_temperature), float(P.tolerance)
SURE = {"known_for": KNOWN_TIME, "agreed_for": 10 * AGREEMENT_TIME, "waited": WARM_TIME, "doubt": 0.0}
"""States of a law that knows how warm the cell is, long after its start."""


def told(temperature: float = ROOM, **given: float) -> Any:
    """Inputs of a cell as warm as its surroundings everywhere, at rest."""
    names = (*SENSED, "ambient_temperature")
    values = dict(zip(COMPONENT.u.names, COMPONENT.start_values()[1].tolist(), strict=True))
    return COMPONENT.u.record(
        {**values, **dict.fromkeys(names, temperature), "speed": 0.0, "torque": 0.0} | given
    )


def begun(u: Any, **states: Any) -> Any:
    return COMPONENT.x.record({**law.begin(u, P), **states})


def later(x: Any, u: Any, samples: int = 1) -> Any:
    for k in range(samples):
        x = COMPONENT.x.record(law.update(x, u, P, float(k), 1.0))
    return x


def said(x: Any) -> dict[str, Any]:
    return dict(law.outputs(x, told(), P, 0.0))


@pytest.mark.parametrize("rise", [-8.0, 0.0, 12.0])
def test_a_cell_as_warm_as_its_surroundings_has_grown_evenly_and_stays_so(rise: float) -> None:
    u = told(ROOM + rise)
    grown = rise * float(P.elongation_per_kelvin)
    first = begun(u)
    assert float(first.elongation) == pytest.approx(grown, abs=1e-9)
    assert float(first.correction) == 0.0
    still = later(first, u, 5)
    assert float(elongation(law.filters_of(still).quiet.mean, P)) == pytest.approx(grown, abs=0.02e-6)


def test_heat_does_not_depend_on_the_direction_in_which_the_joint_turns() -> None:
    u = told(speed=3.0, torque=2.5)
    one, other = (later(begun(each), each, 3) for each in (u, u._replace(speed=-3.0, torque=-2.5)))
    for name in one._fields:
        if name not in ("believed_speed", "believed_torque"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    assert float(one.believed_speed) == 3.0
    assert float(other.believed_speed) == -3.0


@pytest.mark.parametrize(
    ("waited", "most"),
    [(WARM_TIME + 1.0, law.STEADY * TOLERANCE), (0.5 * WARM_TIME, MARGIN * TOLERANCE)],
)
def test_long_after_a_start_it_moves_slowly_and_soon_after_as_far_as_the_witnesses_allow(
    waited: float, most: float
) -> None:
    """The filter says 30 um where the duty says none."""
    u = told()
    first = begun(u, **SURE | {"waited": waited})
    row = np.asarray(P.elongation_row)
    grown = np.array(first.estimate)
    grown[: 2 * row.size] += np.repeat(30e-6 * row / float(row @ row), 2)
    after = later(first._replace(estimate=grown, smoothed=first.smoothed + 30e-6), u)
    assert float(after.elongation - first.elongation) == pytest.approx(most, rel=1e-6)


def test_an_estimate_that_is_none_moves_nothing_and_warns() -> None:
    first = begun(told(), **SURE, correction=2e-6, elongation=2e-6)
    after = later(first._replace(estimate=np.full_like(first.estimate, 1e6)), told())
    assert float(after.correction) == 2e-6
    assert float(after.elongation) == 2e-6
    assert (float(after.doubt), float(after.distrusted)) == (2.0, 1.0)
    outputs = said(after)
    assert (float(outputs["warning"]), float(outputs["ready"])) == (1.0, 0.0)


@pytest.mark.parametrize(("doubt", "ready", "warning"), [(0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 1.0)])
def test_doubt_costs_being_ready_and_more_of_it_warns(doubt: float, ready: float, warning: float) -> None:
    x = begun(told(), **SURE | {"doubt": doubt})
    outputs = said(x._replace(noise_spread=0.0 * x.noise_spread))
    assert (float(outputs["ready"]), float(outputs["warning"])) == (ready, warning)


def test_what_a_bound_holds_off_the_estimate_counts_as_error_in_full() -> None:
    """The relative uncertainty of the elongation aside, which is told apart by its share."""
    x = begun(told())
    off = 7e-6
    free, held = (float(said(each)["correction_std"]) for each in (x, x._replace(elongation=off)))
    limited = off**2  # the correction is still 0
    assert held**2 - free**2 == pytest.approx(off**2 + limited + (P.relative_std * off) ** 2, rel=1e-6, abs=0)


def test_a_second_first_reading_begins_all_anew_but_where_the_correction_is() -> None:
    """The first reading of the tip was wrong by 20 K."""
    wrong, right = told(tip_temperature=ROOM + 20.0), told()
    before = begun(wrong)
    again, fresh = later(before, right), begun(right)
    for name in again._fields:
        if name not in ("correction", "waited"):
            np.testing.assert_allclose(getattr(again, name), getattr(fresh, name), err_msg=name)
    assert float(again.waited) == 1.0
    assert abs(float(again.correction - before.correction)) <= float(P.correction_rate_limit)


def test_readings_that_are_missing_leave_the_model_alone_to_speak_and_it_is_not_ready() -> None:
    first = begun(told(ROOM + 5.0), **SURE)
    there, away = (later(first, told(ROOM + 5.0, **each)) for each in ({}, dict.fromkeys(SENSED, math.nan)))
    assert (float(there.doubt), float(away.doubt)) == (0.0, 1.0)
    sure = away._replace(noise_spread=0.0 * away.noise_spread)
    assert float(said(sure)["ready"]) == 0.0
    assert float(away.elongation) == pytest.approx(5.0 * float(P.elongation_per_kelvin), abs=0.05e-6)

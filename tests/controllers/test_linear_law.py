"""One sample of the linear observer's law, on the model that ships."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from warmlink.controllers.interface import SENSED
from warmlink.controllers.linear_observer import law
from warmlink.controllers.linear_observer.component import COMPONENT
from warmlink.controllers.linear_observer.model import SENSORS, growth, sensor_row
from warmlink.controllers.regression.law import LARGEST_GROWTH

P: Any = COMPONENT.d.read(np.asarray(COMPONENT.settled(COMPONENT.start_values()[0])))
ROOM = float(P.reference_temperature)


def told(rise: float = 0.0, **given: float) -> Any:
    """Inputs of a machine at rest that is evenly warmer than where its model counts from."""
    even = rise * np.asarray(P.even_profile)
    readings = {
        name: float(P.sensor_reference[i] + np.dot(sensor_row(i, P), even)) for i, name in enumerate(SENSED)
    }
    values = dict(zip(COMPONENT.u.names, COMPONENT.start_values()[1].tolist(), strict=True))
    rest = {"ambient_temperature": ROOM + rise, "speed": 0.0, "torque": 0.0}
    return COMPONENT.u.record({**values, **readings, **rest} | given)


def begun(u: Any, **states: Any) -> Any:
    return COMPONENT.x.record({**law.begin(u, P), **states})


def later(x: Any, u: Any) -> Any:
    return COMPONENT.x.record(law.update(x, u, P, 0.0, 1.0))


@pytest.mark.parametrize("rise", [-5.0, 0.0, 10.0])
def test_a_machine_as_warm_as_its_surroundings_begins_so(rise: float) -> None:
    first = begun(told(rise))
    np.testing.assert_allclose(first.estimate, rise * np.asarray(P.even_profile), rtol=1e-6, atol=1e-12)
    assert float(first.elongation) == pytest.approx(float(growth(first.estimate, P)), abs=0.0)
    assert float(first.correction) == 0.0


def test_the_farther_first_readings_are_from_a_cold_machine_the_less_sure_it_is_at_most_as_designed() -> None:
    warm = [
        told(**{name: getattr(told(), name) + rise for name in SENSED}) for rise in (0.0, 2.0, 10.0, 1000.0)
    ]
    spreads = [
        law._at_start(law.sensed(u), law.believed_at_start(u, P), P).spread / P.start_spread for u in warm
    ]
    shares = [float(np.median(each)) for each in spreads]
    assert shares[0] == pytest.approx(law.COLD)
    assert shares == sorted(shares)
    assert shares[0] < shares[1] < shares[2] <= shares[3] == 1.0


@pytest.mark.parametrize(("speed", "torque"), [(-3.0, 2.0), (3.0, -2.0), (-3.0, -2.0)])
def test_heat_does_not_depend_on_directions(speed: float, torque: float) -> None:
    one, other = (later(begun(u), u) for u in (told(speed=3.0, torque=2.0), told(speed=speed, torque=torque)))
    np.testing.assert_array_equal(one.estimate, other.estimate)
    assert (float(other.believed_speed), float(other.believed_torque)) == (speed, torque)


def test_a_sample_follows_from_the_duty_that_was_told_at_its_start() -> None:
    cold = begun(told())
    rest, work = later(cold, told()), later(cold, told(speed=3.0, torque=2.0))
    np.testing.assert_array_equal(rest.estimate, work.estimate)
    after = [later(each, told()) for each in (rest, work)]
    assert float(growth(after[1].estimate, P)) > float(growth(after[0].estimate, P))


def test_growth_that_is_none_holds_the_correction_and_begins_the_estimate_again() -> None:
    first = begun(told(), correction=3e-6, waited=1e3)
    row = np.asarray(P.growth_row)
    wild = first._replace(estimate=2.0 * LARGEST_GROWTH * row / float(row @ row))
    after = later(wild, told())
    assert float(after.correction) == float(after.elongation) == 3e-6
    assert not np.asarray(after.estimate).any()
    np.testing.assert_array_equal(after.spread, P.start_spread)
    assert float(after.distrusted) == 1.0
    assert float(law.outputs(after, told(), P, 0.0)["ready"]) == 0.0


def test_thermometers_that_are_not_in_use_move_nothing() -> None:
    used = np.asarray(P.sensor_std) > 0
    assert 0 < used.sum() < SENSORS
    away = {name: 400.0 for name, mine in zip(SENSED, used, strict=True) if not mine}
    one, other = (later(begun(told()), told(**each)) for each in ({}, away))
    np.testing.assert_array_equal(one.estimate, other.estimate)

"""The two filters of an observer: what is expected of unknown heat, and which of them leads."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.controllers.interface import SENSED
from warmlink.controllers.kalman import Belief, variance_along
from warmlink.controllers.matrices import symmetric, upper, upper_diagonal
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer.filters import allowed_for, led, quieted, together
from warmlink.controllers.observer.model import HEATS, MODES, SENSORS, STATES, BelievedDuty, known_heat
from warmlink.fmus.component.instance import Instance

P: Any = SimpleNamespace(quiet_share=0.1)
SIZES = [STATES, STATES + 2]


def belief(size: int, seed: int, heat: float = 0.0) -> Belief:
    """Any belief, with the shaft's unknown heat so many standard deviations of its noise from zero."""
    draw = np.random.default_rng(seed)
    roots = draw.normal(size=(2, size, size))
    noise, more = (root @ root.T for root in roots)
    mean = draw.normal(size=size)
    mean[MODES : MODES + HEATS] = heat * noise[MODES, MODES] ** 0.5, 0.0
    return Belief(mean, upper(noise + more), upper(noise))


@pytest.mark.parametrize("size", SIZES)
def test_a_quieted_belief_expects_less_heat_and_is_as_sure_of_all_else(size: int) -> None:
    alert = belief(size, 1)
    quiet = quieted(alert, P)
    heats = slice(MODES, MODES + HEATS)
    before, after = (symmetric(each.spread, size) for each in (alert, quiet))
    assert np.linalg.eigvalsh(after).min() > 0
    assert np.diag(after)[heats] == pytest.approx(0.01 * np.diag(before)[heats])
    others = np.r_[:MODES, MODES + HEATS : size]
    assert np.array_equal(after[np.ix_(others, others)], before[np.ix_(others, others)])
    row = np.r_[np.ones(MODES), np.zeros(size - MODES)]
    assert variance_along(quiet.spread, row) == pytest.approx(variance_along(alert.spread, row))
    assert np.array_equal(quiet.mean, alert.mean)
    assert np.array_equal(quiet.noise_spread, alert.noise_spread)


@pytest.mark.parametrize("size", SIZES)
def test_what_a_camera_reveals_is_allowed_for_in_full(size: int) -> None:
    designed = np.arange(1.0, size + 1)
    shares = allowed_for(designed, 0.1) / designed
    assert shares == pytest.approx([0.01] * STATES + [1.0] * (size - STATES))


@pytest.mark.parametrize(
    ("heat", "seen", "begun_again", "alert_leads"),
    [
        (0.0, 0.0, 0.0, False),
        (4.99, 0.0, 0.0, False),
        (5.01, 0.0, 0.0, True),
        (-5.01, 0.0, 0.0, True),
        (0.0, 15.9, 0.0, False),
        (0.0, 16.1, 0.0, True),
        (0.0, 0.0, 1.0, True),
    ],
)
def test_who_leads(heat: float, seen: float, begun_again: float, alert_leads: bool) -> None:
    """Certain heat gives the alert filter the lead, as do the memory of it and a new start.

    Heat in standard deviations of its noise, evidence in its variances beyond the nine that count for none.
    """
    for size in SIZES:
        alert, quiet = belief(size, 2, heat), belief(size, 3)
        noise = upper_diagonal(alert.noise_spread, size)[MODES:STATES]
        p = SimpleNamespace(quiet_share=0.1, disturbance_std=np.ones(size - MODES))
        filters = led(together(alert, quiet), seen * noise.max(), begun_again, p)
        assert all(np.array_equal(one, other) for one, other in zip(filters.alert, alert, strict=True))
        expected = quieted(alert, p) if alert_leads else quiet
        assert all(np.array_equal(one, other) for one, other in zip(filters.quiet, expected, strict=True))


def test_the_alert_filter_is_a_kalman_filter() -> None:
    """Against dense matrices and all readings of a sample at once, one of them missing for a while.

    Of convection's effect on the errors both keep the diagonal.
    """
    observer = Instance(OBSERVER)
    p = OBSERVER.d.read(np.asarray(OBSERVER.settled(OBSERVER.start_values()[0])))
    rows, sigma = np.reshape(p.sensor_rows, (SENSORS, MODES)), np.asarray(p.sensor_std)
    used = np.flatnonzero(sigma > 0)
    heats = np.column_stack([p.shaft_heat_gain, p.link_heat_gain])
    convection = np.reshape(p.convection, (MODES, MODES))
    random = np.random.default_rng(5)
    readings = dict.fromkeys(SENSED, 295.15)
    observer.set(readings)
    observer.initialize()
    for sample in range(300):
        before = OBSERVER.x.read(np.array(observer.snapshot().states))
        readings = {name: 295.15 + 0.004 * sample + random.normal(0.0, 0.1) for name in SENSED}
        if 100 < sample < 130:
            readings["tip_temperature"] = np.nan
        observer.set({**readings, "speed": 3.0, "torque": 2.0, "ambient_temperature": 295.15})
        observer.step(float(sample), 1.0)
        after = OBSERVER.x.read(np.array(observer.snapshot().states))

        modes, unknown = np.split(before.estimate[::2], [MODES])
        duty = BelievedDuty(after.believed_speed, after.believed_torque, after.believed_ambient)
        mean = np.append(
            p.decay * modes + p.reach * (known_heat(modes, duty, p) + heats @ unknown), p.fade * unknown
        )
        own = np.diag(p.decay + p.reach * duty.speed * np.diag(convection))
        carried = np.block([[own, p.reach[:, None] * heats], [np.zeros((HEATS, MODES)), np.diag(p.fade)]])
        variance = np.append(p.profile_std**2 * (1 - p.decay**2), p.disturbance_std**2 * (1 - p.fade**2))
        spread = carried @ symmetric(before.spread[::2], STATES) @ carried.T + np.diag(variance)
        by_noise = carried @ symmetric(before.noise_spread[::2], STATES) @ carried.T

        read = [i for i in used if np.isfinite(readings[SENSED[i]]) and not after.trust_out[i]]
        seen = np.pad(rows[read], ((0, 0), (0, HEATS)))
        noise = np.diag(sigma[read] ** 2)
        gain = spread @ seen.T @ np.linalg.inv(seen @ spread @ seen.T + noise)
        told = np.array([readings[SENSED[i]] for i in read]) - p.linearisation_temperature
        left = np.eye(STATES) - gain @ seen
        joseph = (left @ each @ left.T + gain @ noise @ gain.T for each in (spread, by_noise))
        assert after.estimate[::2] == pytest.approx(mean + gain @ (told - seen @ mean), abs=1e-10)
        for name, expected in zip(("spread", "noise_spread"), joseph, strict=True):
            assert symmetric(getattr(after, name)[::2], STATES) == pytest.approx(expected, abs=1e-10)

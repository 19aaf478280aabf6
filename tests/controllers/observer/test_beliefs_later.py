"""A sample later: what heat does to the modes, and what is left of errors and added to them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from warmlink.controllers.kalman import Belief
from warmlink.controllers.matrices import symmetric, upper
from warmlink.controllers.observer.component import COMPONENT as OBSERVER
from warmlink.controllers.observer.filters import Filters, together
from warmlink.controllers.observer.model import HEATS, MODES, STATES, BelievedDuty
from warmlink.controllers.observer.prediction import predict

P: Any = OBSERVER.d.read(np.asarray(OBSERVER.settled(OBSERVER.start_values()[0])))
ROOM = float(P.linearisation_temperature)
STILL, MOVING = BelievedDuty(0.0, 0.0, ROOM), BelievedDuty(-3.0, 2.0, ROOM + 2.0)


def filters(means: Any, spread: Any, noise: Any) -> Filters:
    """Two beliefs with other means, and with the same covariances."""
    return together(*(Belief(mean, upper(spread), upper(noise)) for mean in means))


def covariance(seed: int) -> Any:
    root = np.random.default_rng(seed).normal(size=(STATES, STATES))
    return root @ root.T


def transition(speed: float) -> Any:
    """What a sample makes of errors: modes decay and are cooled, unknown heats fade and drive the modes."""
    cooled = np.diag(np.asarray(P.convection).reshape(MODES, MODES)) * abs(speed)
    kept = np.diag([*(P.decay + P.reach * cooled), *np.broadcast_to(P.fade, HEATS)])
    kept[:MODES, MODES] = P.reach * P.shaft_heat_gain
    kept[:MODES, MODES + 1] = P.reach * P.link_heat_gain
    return kept


@pytest.mark.parametrize("duty", [STILL, MOVING], ids=["still", "moving"])
def test_errors_are_carried_over_by_the_transition(duty: BelievedDuty) -> None:
    """Noise as F P F' alone; the whole error grows by what either filter expects, the quiet one of less."""
    spread, noise = covariance(1), covariance(2)
    later = predict(filters(np.zeros((2, STATES)), spread, noise), duty, P)
    f = transition(float(duty.speed))
    added = []
    for each in (later.alert, later.quiet):
        np.testing.assert_allclose(
            symmetric(each.noise_spread, STATES), f @ noise @ f.T, rtol=1e-9, atol=1e-9
        )
        grown = symmetric(each.spread, STATES) - f @ spread @ f.T
        np.testing.assert_allclose(grown, np.diag(np.diag(grown)), atol=1e-9)
        added.append(np.diag(grown))
    shape = P.disturbance_std**2 * (1.0 - P.fade**2)
    np.testing.assert_allclose(added[0][MODES:], np.broadcast_to(shape, HEATS), rtol=1e-6)
    assert (added[0][MODES:] > 2 * added[1][MODES:]).all()
    assert (added[0][:MODES] >= -1e-9).all()


def test_unknown_heat_drives_the_modes_and_fades() -> None:
    heats, zero = np.array([3.0, -2.0]), np.zeros(STATES)
    heated = np.array([*zero[:MODES], *heats])
    later = predict(filters((heated, zero), np.eye(STATES), np.eye(STATES)), MOVING, P)
    driven = later.alert.mean - later.quiet.mean
    gained = P.shaft_heat_gain * heats[0] + P.link_heat_gain * heats[1]
    np.testing.assert_allclose(driven[:MODES], P.reach * gained, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(driven[MODES:], P.fade * heats, rtol=1e-12)


def test_modes_decay_at_rest_and_warm_where_it_moves() -> None:
    warm, zero = np.array([*np.linspace(1.0, 2.0, MODES), 0.0, 0.0]), np.zeros(STATES)
    later = predict(filters((warm, zero), np.eye(STATES), np.eye(STATES)), STILL, P)
    np.testing.assert_allclose(
        (later.alert.mean - later.quiet.mean)[:MODES], P.decay * warm[:MODES], rtol=1e-9
    )
    moved = predict(filters((zero, zero), np.eye(STATES), np.eye(STATES)), MOVING, P)
    assert np.dot(P.elongation_row, moved.alert.mean[:MODES]) > np.dot(
        P.elongation_row, later.quiet.mean[:MODES]
    )


def test_at_rest_modes_stay_as_uncertain_as_the_profile_and_the_quiet_filter_expects_its_share() -> None:
    profile = np.asarray(P.profile_std) ** 2
    assert (profile > 0).any()
    spread = np.diag([*profile, *[0.0] * HEATS])
    later = predict(filters(np.zeros((2, STATES)), spread, spread), STILL, P)
    alert, quiet = (np.diag(symmetric(each.spread, STATES))[:MODES] for each in (later.alert, later.quiet))
    np.testing.assert_allclose(alert, profile, rtol=1e-9)
    fresh = P.quiet_share**2 * (1.0 - P.decay**2) * profile
    np.testing.assert_allclose(quiet, P.decay**2 * profile + fresh, rtol=1e-9)

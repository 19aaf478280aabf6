"""A designed observer in the long run, against the discrete filter, and what more thermometers bring."""

import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are

from warmlink.controllers.design.gains import Unknown
from warmlink.controllers.design.plant import INPUTS, OUTPUTS, USUAL_SPEED, plant_model
from warmlink.controllers.design.reduction import reduce_plant
from warmlink.controllers.design.steady import steady, worth
from warmlink.controllers.observer.model import MODES

REDUCED, UNKNOWN = reduce_plant(plant_model(), MODES), Unknown()
NOISE = {"base_temperature": 0.1, "tip_temperature": 0.2}


def test_the_error_is_that_of_the_discrete_filter() -> None:
    A, B = REDUCED.at(USUAL_SPEED)
    order, period = len(A), 1.0
    state = np.zeros((order + 2, order + 2))
    state[:order, :order] = A
    state[:order, order:] = B[:, [INPUTS.index("shaft_heat"), INPUTS.index("link_heat")]]
    times = np.array([UNKNOWN.shaft_heat_time, UNKNOWN.link_heat_time])
    state[order:, order:] = np.diag(-1 / times)
    spread = np.array([UNKNOWN.shaft_heat, UNKNOWN.link_heat]) ** 2
    driven = np.diag([*np.zeros(order), *(2 * spread / times)]) * period
    seen = np.pad(REDUCED.C, ((0, 0), (0, 2)))[[OUTPUTS.index(name) for name in NOISE]]
    before = solve_discrete_are(expm(state * period).T, seen.T, driven, np.diag(np.square([*NOISE.values()])))
    growth = np.pad(REDUCED.C[OUTPUTS.index("elongation")], (0, 2))
    expected = np.hypot(np.sqrt(growth @ before @ growth), REDUCED.error.elongation_step)
    assert steady(REDUCED, UNKNOWN, NOISE, period).error == pytest.approx(expected, rel=0.02)


def test_another_thermometer_never_makes_it_worse() -> None:
    sets = {frozenset(some): error for some, error in worth(REDUCED, UNKNOWN, NOISE, 1.0).items()}
    assert len(sets) == 4
    for some, error in sets.items():
        for more in sets:
            assert not some < more or sets[more] < error


def test_the_filter_is_stable_and_has_a_gain_for_each_thermometer() -> None:
    found = steady(REDUCED, UNKNOWN, NOISE, 1.0)
    assert found.gains.shape == (2,)
    assert found.time_constants.shape == (REDUCED.order + 2,)
    assert (found.time_constants > 0).all()

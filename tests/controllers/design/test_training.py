"""Runs of a linear system are exact for inputs that are held over a step."""

import math

import numpy as np

from warmlink.controllers.design.training import over_a_step


def test_a_lag_decays_and_follows_what_is_held() -> None:
    transition, reach = over_a_step(np.array([[-0.5]]), np.array([[2.0]]), 3.0)
    np.testing.assert_allclose(transition, [[math.exp(-1.5)]], rtol=1e-14)
    np.testing.assert_allclose(reach, [[4.0 * (1 - math.exp(-1.5))]], rtol=1e-14)


def test_a_push_that_is_held_moves_by_half_of_the_time_squared() -> None:
    """Of two inputs the second does nothing; the rates have no inverse."""
    transition, reach = over_a_step(
        np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0, 0.0], [1.0, 0.0]]), 4.0
    )
    np.testing.assert_allclose(transition, [[1.0, 4.0], [0.0, 1.0]], rtol=1e-14)
    np.testing.assert_allclose(reach, [[8.0, 0.0], [4.0, 0.0]], rtol=1e-14)

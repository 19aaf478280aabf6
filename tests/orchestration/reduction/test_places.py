"""The nearest place of a body, beside that by non-negative least squares."""

import numpy as np
import pytest
from scipy.optimize import nnls

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.reduction.places import nearest

FIRMLY = 1e6
"""How much more it counts that weights add up to 1."""


def distance(place: Array, corners: Array) -> float:
    """Distance to one simplex."""
    weights, _ = nnls(np.vstack([corners, np.full(corners.shape[1], FIRMLY)]), np.append(place, FIRMLY))
    return float(np.linalg.norm(corners @ weights - place))


@pytest.mark.parametrize("corners", [3, 4], ids=["triangles", "tetrahedra"])
def test_no_place_is_nearer(corners: int) -> None:
    rng = np.random.default_rng(0)
    for _ in range(40):
        body, place = rng.normal(size=(3, corners, 12)), 2 * rng.normal(size=3)
        found, number, weights = nearest(place, body)
        expected = min(distance(place, each) for each in np.moveaxis(body, 2, 0))
        assert found == pytest.approx(expected, rel=1e-5, abs=1e-5)
        assert weights.min() >= 0
        assert weights.sum() == pytest.approx(1.0)
        assert np.linalg.norm(body[:, :, number] @ weights - place) == pytest.approx(found, abs=1e-12)

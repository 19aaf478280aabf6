"""The place of a body of triangles or tetrahedra that is nearest to a point."""

from itertools import chain, combinations

import numpy as np

from warmlink.orchestration.arrays import Array


def nearest(place: Array, corners: Array) -> tuple[float, int, Array]:
    """Distance from a place [m] to the nearest of triangles or tetrahedra, its number, its corners' weights.

    Corners are of shape (3, 3 or 4, n) [m]; their weighted sum is the nearest point.
    """
    middles = corners.mean(axis=1)
    around = np.linalg.norm(corners - middles[:, None], axis=0).max(axis=0)
    apart = np.linalg.norm(middles - place[:, None], axis=0)
    # None further away than any point of another one.
    few = np.flatnonzero(apart - around <= (apart + around).min())
    sides = range(1, corners.shape[1] + 1)
    # The nearest point lies inside a corner, an edge, a face or the whole.
    every = chain.from_iterable(combinations(range(corners.shape[1]), count) for count in sides)
    found = [_projected(place, corners[:, :, few], list(side)) for side in every]
    distances = np.array([distance for distance, _ in found])
    side, index = np.unravel_index(int(np.argmin(distances)), distances.shape)
    return float(distances[side, index]), int(few[index]), found[side][1][:, index]


def _projected(place: Array, corners: Array, side: list[int]) -> tuple[Array, Array]:
    """Distances to the foot of the perpendicular on a side, infinite where that lies beside it; weights."""
    first = corners[:, side[0]]
    edges = np.moveaxis(corners[:, side[1:]] - first[:, None], 2, 0)
    shares = np.einsum("nij,jn->in", np.linalg.pinv(edges), place[:, None] - first)
    weights = np.zeros(corners.shape[1:])
    weights[side] = np.vstack([1 - shares.sum(axis=0), shares])
    distance = np.linalg.norm(np.einsum("kin,in->kn", corners, weights) - place[:, None], axis=0)
    return np.where(weights.min(axis=0) >= 0, distance, np.inf), weights

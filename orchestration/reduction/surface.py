"""Places on triangles and in tetrahedra, and the surface of a mesh: parted at its edges, and coarser."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from warmlink.orchestration.arrays import Array

Integers = NDArray[np.int64]

EDGE_ANGLE = 30.0
"""degrees between the normals of neighbouring facets, above which an edge parts two faces."""


class Nearest(NamedTuple):
    """Number of the simplex nearest to a point, weights of its corners there, distance from it [m]."""

    cell: int
    weights: Array
    distance: float


def nearest(place: Array, corners: Array) -> Nearest:
    """Simplex nearest to a place, shape (3,), of triangles or tetrahedra by corners, (3, 3 or 4, n) [m].

    Inside a simplex the distance is exact; beside it, weights below 0 are set to 0.
    """
    first = corners[:, 0]
    edges = np.moveaxis(corners[:, 1:] - first[:, None], 2, 0)
    shares = np.einsum("nij,jn->in", np.linalg.pinv(edges), place[:, None] - first)
    weights = np.maximum(np.vstack([1 - shares.sum(axis=0), shares]), 0.0)
    weights /= weights.sum(axis=0)
    distance = np.linalg.norm(np.einsum("kin,in->kn", corners, weights) - place[:, None], axis=0)
    index = int(np.argmin(distance))
    return Nearest(index, weights[:, index], float(distance[index]))


def patches(mesh: Any, facets: Integers) -> list[Integers]:
    """Boundary facets of an `skfem.MeshTet`, parted into faces at sharp edges."""
    normals = facet_normals(mesh.p[:, mesh.facets[:, facets]])
    normals /= np.linalg.norm(normals, axis=0)
    edges = mesh.f2e[:, facets].ravel()
    order = np.argsort(edges, kind="stable")
    shared = np.flatnonzero(np.diff(edges[order]) == 0)
    a, b = order[shared] % len(facets), order[shared + 1] % len(facets)
    # Corners are in no particular order, so that normals point either way.
    smooth = np.abs(np.sum(normals[:, a] * normals[:, b], axis=0)) > np.cos(np.radians(EDGE_ANGLE))
    patch = connected(a[smooth], b[smooth], len(facets))
    return [facets[patch == i] for i in np.unique(patch)]


def connected(a: Integers, b: Integers, count: int) -> Integers:
    """Number of the group, from 0 on, of each of so many things, of which a[i] and b[i] are joined."""
    joined = coo_matrix((np.ones(len(a)), (a, b)), shape=(count, count))
    return np.asarray(connected_components(joined, directed=False)[1])


def facet_normals(corners: Array) -> Array:
    """Normals of triangles, shape (3, n) [m2], twice as long as their area; corners as of `nearest`."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], axis=0)


def coarsened(corners: Array, triangles: Integers, most: int) -> tuple[Integers, Integers]:
    """Surface with fewer corners: those in one cell of a grid become one.

    J. Rossignac and P. Borrel, "Multi-resolution 3D approximations for rendering complex scenes", in
    *Modeling in Computer Graphics*, Springer 1993.

    From corners, shape (3, n) [m], and their numbers in triangles, shape (3, m): the numbers of at `most` so
    many corners that stay, and triangles by the number among these.
    """
    used, place = np.unique(triangles, return_inverse=True)
    cell = float(np.ptp(corners, axis=1).max()) / 1e4
    while True:
        cells = np.round(corners[:, used] / cell).astype(np.int64)
        _, first, owner = np.unique(cells, axis=1, return_index=True, return_inverse=True)
        if len(first) <= most:
            a, b, c = merged = owner.ravel()[place].reshape(triangles.shape)
            return used[first], merged[:, (a != b) & (b != c) & (a != c)]
        cell *= 1.2

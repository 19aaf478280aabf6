"""What of a hexahedral mesh is seen: its outer surface as triangles, its edges as lines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Surface:
    """Quadrilaterals of the surface by their nodes in order around, shape (4, n)."""

    quadrilaterals: Integers

    @property
    def triangles(self) -> Integers:
        """Two triangles for each quadrilateral, shape (3, 2 n)."""
        a, b, c, d = self.quadrilaterals
        return np.concatenate([np.stack([a, b, c]), np.stack([a, c, d])], axis=1)

    def edges(self, points: Array) -> Array:
        """Outlines as one line, shape (3, m), broken by NaN; `points` of shape (3, nodes)."""
        around = points[:, self.quadrilaterals[[0, 1, 2, 3, 0]]]
        gaps = np.full((3, 1, around.shape[2]), np.nan)
        return np.concatenate([around, gaps], axis=1).transpose(0, 2, 1).reshape(3, -1)


def outer_surface(mesh: Any) -> Surface:
    """Return the boundary facets of an `skfem.MeshHex`."""
    return Surface(_around(mesh, mesh.boundary_facets()))


def plan_lines(mesh: Any, points: Array, level: float) -> tuple[Array, Array]:
    """Element edges on the face z = `level` [m], drawn at `points`, shape (3, nodes), as a broken line.

    Returns
    -------
    x and y, with NaN between the pieces
    """
    on_face = np.all(np.abs(mesh.p[2][mesh.facets] - level) < 1e-7, axis=0)
    x, y, _ = Surface(_around(mesh, np.flatnonzero(on_face))).edges(points)
    return x, y


def _around(mesh: Any, facets: Integers) -> Integers:
    """Nodes of facets in order around: of the three ways to pair them, the diagonals span the most."""
    nodes = mesh.facets[:, facets]
    p = mesh.p[:, nodes]
    ways = [(0, 1, 2, 3), (0, 2, 1, 3), (0, 1, 3, 2)]
    spans = [
        np.linalg.norm(np.cross(p[:, way[2]] - p[:, way[0]], p[:, way[3]] - p[:, way[1]], axis=0), axis=0)
        for way in ways
    ]
    best = np.array(ways).T[:, np.argmax(spans, axis=0)]
    return np.asarray(np.take_along_axis(nodes, best, axis=0))

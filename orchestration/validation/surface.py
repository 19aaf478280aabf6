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
        """Outlines as one broken line, shape (3, m), with NaN between the pieces; `points` of shape (3, nodes)."""
        around = points[:, self.quadrilaterals[[0, 1, 2, 3, 0]]]
        gaps = np.full((3, 1, around.shape[2]), np.nan)
        return np.concatenate([around, gaps], axis=1).transpose(0, 2, 1).reshape(3, -1)


def outer_surface(mesh: Any) -> Surface:
    """Return the boundary facets of an `skfem.MeshHex`."""
    return Surface(_around(mesh, mesh.boundary_facets()))


def plan_lines(mesh: Any, points: Array, level: float) -> tuple[Array, Array]:
    """Element edges of the mesh's face at z = `level` [m], drawn at `points`, shape (3, nodes), as a broken line.

    Returns
    -------
    x and y, with NaN between the pieces
    """
    on_face = np.all(np.abs(mesh.p[2][mesh.facets] - level) < 1e-7, axis=0)
    x, y, _ = Surface(_around(mesh, np.flatnonzero(on_face))).edges(points)
    return x, y


def _around(mesh: Any, facets: Integers) -> Integers:
    """Nodes of facets in order around: the one farthest from the first lies opposite to it."""
    nodes = mesh.facets[:, facets]
    distance = np.linalg.norm(mesh.p[:, nodes] - mesh.p[:, nodes[0]][:, None], axis=0)
    opposite = distance.argmax(axis=0)
    rest = np.array([[r for r in (1, 2, 3) if r != o] for o in opposite]).T.reshape(2, -1)
    column = np.arange(nodes.shape[1])
    return np.stack([nodes[0], nodes[rest[0], column], nodes[opposite, column], nodes[rest[1], column]])

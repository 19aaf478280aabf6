"""What a page draws of a part: its surface, and how it warms up and moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.reduction.elements import Elements
from warmlink.orchestration.reduction.mesh_error import warmed
from warmlink.orchestration.reduction.simplices import coarsened
from warmlink.orchestration.reduction.subspace import DenseHeat, Range

MOST_CORNERS = 3000
"""Of a drawn surface, so that a page stays small."""


@dataclass(frozen=True, eq=False)
class Picture:
    """Surface of a part at the times of `mesh_error.TIMES`.

    Attributes
    ----------
    corners : shape (3, n) [m]
    triangles : numbers of corners, shape (3, m)
    rises : above the initial temperature, shape (times, n) [K]
    displacements : relative to the heated face, shape (times, 3, n) [m]
    """

    corners: Array
    triangles: NDArray[np.int64]
    rises: Array
    displacements: Array


def drawn(mesh: Any, elements: Elements, heat: DenseHeat, within: Range) -> Picture:
    """Picture of a part after a step of heat flow, from its elements and its heat in their span."""
    rises = (heat.patterns @ warmed(heat, within)).T
    moved = within.material["expansion_coefficient"] * elements.displacements(rises)
    kept, triangles = coarsened(mesh.p, mesh.facets[:, mesh.boundary_facets()], MOST_CORNERS)
    # Corners come before the middles of edges.
    return Picture(mesh.p[:, kept], triangles, rises[:, kept], moved[:, :, kept])

"""Blocks of a structured mesh: the plan of link, shaft and diode in quadrilaterals, and their extrusion."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.paper.data import Geometry
from warmlink.orchestration.paper.fea.library import scikit_fem

Array = NDArray[np.float64]

#: Nodes nearer to each other than this are one node [m].
MERGE_DISTANCE = 1e-8


@dataclass(frozen=True)
class Patch:
    """A quadrilateral of the plan, corners anticlockwise, whose edges may be arcs: edge number -> centre."""

    corners: Array  # (4, 2)
    arcs: dict[int, tuple[float, float]]

    def grid(self, n: int) -> Array:
        """Points of a division into n x n, shape (n + 1, n + 1, 2), by transfinite interpolation."""
        s = np.linspace(0, 1, n + 1)
        bottom, right = self._edge(0, s), self._edge(1, s)
        top, left = self._edge(2, s)[::-1], self._edge(3, s)[::-1]
        u, v = s[:, None, None], s[None, :, None]
        c = self.corners
        bilinear = (1 - u) * (1 - v) * c[0] + u * (1 - v) * c[1] + u * v * c[2] + (1 - u) * v * c[3]
        across = (1 - v) * bottom[:, None] + v * top[:, None]
        along = (1 - u) * left[None] + u * right[None]
        return np.asarray(across + along - bilinear)

    def _edge(self, number: int, s: Array) -> Array:
        a, b = self.corners[number], self.corners[(number + 1) % 4]
        if number not in self.arcs:
            return np.asarray(a + s[:, None] * (b - a))
        centre = np.array(self.arcs[number])
        start = np.arctan2(*(a - centre)[::-1])
        turn = np.arctan2(*(b - centre)[::-1]) - start
        turn = (turn + np.pi) % (2 * np.pi) - np.pi
        angle = start + s * turn
        return np.asarray(centre + np.hypot(*(a - centre)) * np.stack([np.cos(angle), np.sin(angle)], axis=1))


class HexBuilder:
    """Collects extruded grids into one mesh, merging nodes that coincide."""

    def __init__(self) -> None:
        self._numbers: dict[tuple[int, ...], int] = {}
        self._points: list[tuple[float, float, float]] = []
        self._cells: list[tuple[int, ...]] = []
        self._regions: dict[str, list[int]] = {}

    def extrude(self, region: str, grids: Iterable[Array], levels: Array) -> None:
        """Add a column of hexahedra over every grid, shape (n, m, 2) [m], between the levels along z [m]."""
        # scikit-fem numbers a hexahedron's corners from (1, 1, 1) down to (0, 0, 0) in this order.
        corners = [(1, 1, 1), (1, 1, 0), (1, 0, 1), (0, 1, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0)]
        members = self._regions.setdefault(region, [])
        for grid in grids:
            number = self._number(grid, levels)
            for i, j, k in np.ndindex(grid.shape[0] - 1, grid.shape[1] - 1, len(levels) - 1):
                members.append(len(self._cells))
                self._cells.append(tuple(number[i + a, j + b, k + c] for a, b, c in corners))

    def mesh(self) -> Any:
        """Return the `skfem.MeshHex` with the regions as its subdomains."""
        mesh = scikit_fem().MeshHex(np.array(self._points).T.copy(), np.array(self._cells).T.copy())
        return mesh.with_subdomains({name: np.array(cells) for name, cells in self._regions.items()})

    def _number(self, grid: Array, levels: Array) -> NDArray[np.int64]:
        number = np.empty((*grid.shape[:2], len(levels)), dtype=np.int64)
        for i, j, k in np.ndindex(*number.shape):
            point = (float(grid[i, j, 0]), float(grid[i, j, 1]), float(levels[k]))
            # The irrational shift keeps round dimensions away from the bins' edges.
            key = tuple(int(np.floor(c / MERGE_DISTANCE + 1 / np.pi)) for c in point)
            if key not in self._numbers:
                self._numbers[key] = len(self._points)
                self._points.append(point)
            number[i, j, k] = self._numbers[key]
        return number


def plan(g: Geometry) -> tuple[list[Patch], list[Patch], list[Patch]]:
    """Patches seen along the shaft: the link without its holes, the shaft's ring, the diode's disc."""
    half = g.width / 2
    holes = [(g.shaft_centre, g.shaft_diameter / 2), (g.diode_centre, g.diode_diameter / 2)]
    (x_s, r_s), (x_d, r_d) = holes
    a, b = r_s / np.sqrt(2), r_d / np.sqrt(2)
    x = np.concatenate(
        [[0.0, (x_s - a) / 2], [x_s - a, x_s], np.linspace(x_s + a, x_d - b, 17), [x_d, x_d + b, g.length]]
    )
    inner = np.interp(x, [x_s + a, x_d - b], [a, b])
    node = np.array([[(x_i, y) for y in (-half, -d, 0.0, d, half)] for x_i, d in zip(x, inner, strict=True)])
    # The middle of each edge of a block moves out onto the circle; the block's own centre is the hole's.
    for column, (_, r) in ((3, holes[0]), (21, holes[1])):
        centre = node[column, 2].copy()
        node[column - 1, 2, 0], node[column + 1, 2, 0] = centre[0] - r, centre[0] + r
        node[column, 1, 1], node[column, 3, 1] = -r, r
    plate = []
    for i, j in np.ndindex(len(x) - 1, 4):
        if i in (2, 3, 20, 21) and j in (1, 2):
            continue
        plate.append(Patch(node[[i, i + 1, i + 1, i], [j, j, j + 1, j + 1]], _arcs_beside(i, j, holes)))
    return plate, _ring(x_s, g.shaft_bore / 2, r_s), _disc(x_d, r_d)


def _arcs_beside(i: int, j: int, holes: Sequence[tuple[float, float]]) -> dict[int, tuple[float, float]]:
    """Which edges of the plate's patch (i, j) lie on a hole: edges 0 to 3 are below, right, above, left."""
    for first, (x, _) in zip((2, 20), holes, strict=True):
        in_columns, in_rows = i in (first, first + 1), j in (1, 2)
        if in_columns and j == 0:
            return {2: (x, 0.0)}
        if in_columns and j == 3:
            return {0: (x, 0.0)}
        if in_rows and i == first - 1:
            return {1: (x, 0.0)}
        if in_rows and i == first + 2:
            return {3: (x, 0.0)}
    return {}


def _ring(x: float, inner: float, outer: float) -> list[Patch]:
    centre = (x, 0.0)
    angle = np.arange(9) * np.pi / 4
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    near, far = np.array(centre) + inner * around, np.array(centre) + outer * around
    return [
        Patch(np.array([near[i], far[i], far[i + 1], near[i + 1]]), {1: centre, 3: centre}) for i in range(8)
    ]


def _disc(x: float, radius: float) -> list[Patch]:
    """Four patches make a square core with straight edges, eight a ring from it to the circle."""
    half = 0.5 * radius
    core = np.array([[(x + half * i, half * j) for j in (-1, 0, 1)] for i in (-1, 0, 1)])
    patches = [Patch(core[[i, i + 1, i + 1, i], [j, j, j + 1, j + 1]], {}) for i, j in np.ndindex(2, 2)]
    order = [(2, 1), (2, 2), (1, 2), (0, 2), (0, 1), (0, 0), (1, 0), (2, 0), (2, 1)]
    near = np.array([core[i, j] for i, j in order])
    angle = np.arange(9) * np.pi / 4
    far = np.array([x, 0.0]) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ring = [Patch(np.array([near[i], far[i], far[i + 1], near[i + 1]]), {1: (x, 0.0)}) for i in range(8)]
    return patches + ring


def lines(at: Sequence[float], counts: Iterable[int]) -> Array:
    """Grid lines through the given positions, with so many elements between each two."""
    pieces = [np.linspace(a, b, n + 1)[:-1] for a, b, n in zip(at[:-1], at[1:], counts, strict=True)]
    return np.concatenate([*pieces, [at[-1]]])

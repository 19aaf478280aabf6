"""Blocks of a structured mesh: the plan of link, shaft and diode in quadrilaterals, and their extrusion."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.paper.data import Geometry
from warmlink.orchestration.paper.fea.library import scikit_fem

#: Nodes nearer to each other than this are one node [m].
MERGE_DISTANCE = 1e-8

Circle = tuple[float, float]
"""Place of its centre along the link's middle line, and radius [m]."""


def hexahedra(columns: Iterable[tuple[str, Array, Array]]) -> Any:
    """Extrude each grid, shape (n, m, 2) [m], over its levels [m] into one `skfem.MeshHex`, nodes merged.

    The names before the grids become its subdomains.
    """
    # scikit-fem numbers a hexahedron's corners from (1, 1, 1) down to (0, 0, 0) in this order.
    corners = [(1, 1, 1), (1, 1, 0), (1, 0, 1), (0, 1, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0)]
    points: list[Array] = []
    cells: list[NDArray[np.int64]] = []
    owner: list[str] = []
    count = 0
    for region, grid, levels in columns:
        n, m, k = *grid.shape[:2], len(levels)
        points.append(np.vstack([np.repeat(grid.reshape(-1, 2), k, axis=0).T, np.tile(levels, n * m)]))
        number = count + np.arange(n * m * k).reshape(n, m, k)
        cells.append(
            np.stack([number[a : n - 1 + a, b : m - 1 + b, c : k - 1 + c].ravel() for a, b, c in corners])
        )
        owner += [region] * cells[-1].shape[1]
        count += number.size
    p = np.hstack(points)
    # The irrational shift keeps round dimensions away from the bins' edges.
    bins = np.floor(p / MERGE_DISTANCE + 1 / np.pi)
    _, first, node = np.unique(bins, axis=1, return_index=True, return_inverse=True)
    places, corner_nodes = np.ascontiguousarray(p[:, first]), node.reshape(-1)[np.hstack(cells)]
    mesh = scikit_fem().MeshHex(places, np.ascontiguousarray(corner_nodes))
    return mesh.with_subdomains({name: np.flatnonzero(np.array(owner) == name) for name in set(owner)})


def plan(g: Geometry, n: int) -> dict[str, list[Array]]:
    """Grids of n x n elements, seen along the shaft: link without holes, shaft's ring, diode's disc."""
    half = g.width / 2
    x_s, r_s = shaft = g.shaft_centre, g.shaft_diameter / 2
    x_d, r_d = diode = g.diode_centre, g.diode_diameter / 2
    a, b = r_s / np.sqrt(2), r_d / np.sqrt(2)
    x = np.concatenate(
        [[0.0, (x_s - a) / 2], [x_s - a, x_s], np.linspace(x_s + a, x_d - b, 17), [x_d, x_d + b, g.length]]
    )
    inner = np.interp(x, [x_s + a, x_d - b], [a, b])
    node = np.array([[(x_i, y) for y in (-half, -d, 0.0, d, half)] for x_i, d in zip(x, inner, strict=True)])
    # The middle of each edge of a block moves out onto the circle; the block's own centre is the hole's.
    for column, (centre, r) in ((3, shaft), (21, diode)):
        node[column - 1, 2, 0], node[column + 1, 2, 0] = centre - r, centre + r
        node[column, 1, 1], node[column, 3, 1] = -r, r
    holes = [(i, j) for i in (2, 3, 20, 21) for j in (1, 2)]
    plate = [
        node[[i, i + 1, i + 1, i], [j, j, j + 1, j + 1]]
        for i, j in np.ndindex(len(x) - 1, 4)
        if (i, j) not in holes
    ]
    bore = x_s, g.shaft_bore / 2
    core = np.array([[(x_d + r_d / 2 * i, r_d / 2 * j) for j in (-1, 0, 1)] for i in (-1, 0, 1)])
    # The diode is a square core with straight edges and a ring from it to the circle.
    squares = [core[[i, i + 1, i + 1, i], [j, j, j + 1, j + 1]] for i, j in np.ndindex(2, 2)]
    edge = core[[2, 2, 1, 0, 0, 0, 1, 2, 2], [1, 2, 2, 2, 1, 0, 0, 0, 1]]
    blocks = {
        "link": plate,
        "shaft": _ring(_around(bore), _around(shaft)),
        "diode": squares + _ring(edge, _around(diode)),
    }
    circles = (shaft, bore, diode)
    return {name: [_grid(corners, circles, n) for corners in block] for name, block in blocks.items()}


def _around(circle: Circle) -> Array:
    """Nine points around a circle, the last being the first."""
    angle = np.arange(9) * np.pi / 4
    return np.array([circle[0], 0.0]) + circle[1] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _ring(near: Array, far: Array) -> list[Array]:
    """Quadrilaterals between an inner and an outer outline."""
    return [np.array([near[i], far[i], far[i + 1], near[i + 1]]) for i in range(8)]


def _grid(corners: Array, circles: Sequence[Circle], n: int) -> Array:
    """Divide a quadrilateral into n x n by transfinite interpolation, shape (n + 1, n + 1, 2).

    Corners are anticlockwise, shape (4, 2); an edge with both ends on one of the circles is an arc of it.
    """
    s = np.linspace(0, 1, n + 1)
    bottom, right, top, left = (_edge(corners[i], corners[(i + 1) % 4], circles, s) for i in range(4))
    u, v = s[:, None, None], s[None, :, None]
    c = corners
    bilinear = (1 - u) * (1 - v) * c[0] + u * (1 - v) * c[1] + u * v * c[2] + (1 - u) * v * c[3]
    across = (1 - v) * bottom[:, None] + v * top[::-1][:, None]
    return np.asarray(across + (1 - u) * left[::-1][None] + u * right[None] - bilinear)


def _edge(a: Array, b: Array, circles: Sequence[Circle], s: Array) -> Array:
    for x, radius in circles:
        centre = np.array([x, 0.0])
        if np.allclose(
            [np.hypot(*(a - centre)), np.hypot(*(b - centre))], radius, rtol=0, atol=MERGE_DISTANCE
        ):
            start = np.arctan2(*(a - centre)[::-1])
            turn = (np.arctan2(*(b - centre)[::-1]) - start + np.pi) % (2 * np.pi) - np.pi
            angle = start + s * turn
            return np.asarray(centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    return np.asarray(a + s[:, None] * (b - a))


def lines(at: Sequence[float], counts: Iterable[int]) -> Array:
    """Grid lines through the given positions, with so many elements between each two."""
    pieces = [np.linspace(a, b, n + 1)[:-1] for a, b, n in zip(at[:-1], at[1:], counts, strict=True)]
    return np.concatenate([*pieces, [at[-1]]])

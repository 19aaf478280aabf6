"""Structured hexahedral meshes: a plain bar, and link with hollow shaft and laser diode.

[1] V (see `data`) gives 23 x 4 x 1 elements for the link, 7 along and 8 around the shaft, 10 along and 12 in
the cross section of the diode. These counts fit together without hanging nodes in one way, assumed here: a
2 x 2 block of the link's elements makes room for each hole, the block's 8 edges being the 8 elements around;
the diode's section is 2 x 2 elements within a ring of 8.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.finite_elements.body import Body, Material, Support, mean_at, scikit_fem
from warmlink.orchestration.paper.data import GEOMETRY, MATERIALS, Geometry

MERGE_DISTANCE = 1e-8
"""m; nodes nearer to each other than this are one node."""

Circle = tuple[float, float]
"""Place of its centre along the link's middle line, and radius [m]."""


@dataclass(frozen=True)
class RodMesh:
    """What is built around the link, beyond the geometry.

    `refinement` divides every element of the paper's mesh into that many along each direction. `pad_gap`
    [m] is the stretch of bare shaft between the link and the heated surface (the paper does not give it).
    `elongation_at` selects what is measured from the shaft's centre: `above`, to the edge of the diode's hole
    ([1] VI.B); `centre`, to the mean around it; `clear`, the link between the two holes.
    """

    refinement: int = 1
    pad_gap: float = 0.0
    diode: bool = True
    elongation_at: str = "above"
    only_link_cooled: bool = False


AS_DESCRIBED = RodMesh()


def bare_link(refinement: int = 1, g: Geometry = GEOMETRY, material: Material = MATERIALS["link"]) -> Body:
    """Build the link alone, without holes, heated over its whole section at the shaft's centre.

    It is the 3-D counterpart of the 1-D link: all faces are cooled, the elongation runs between two sections.
    """
    x = _lines([0.0, g.shaft_centre, g.diode_centre, g.length], [2, 20, 1], refinement)
    y = np.linspace(-g.width / 2, g.width / 2, 4 * refinement + 1)
    z = np.linspace(0, g.thickness, refinement + 1)
    mesh = scikit_fem().MeshHex.init_tensor(x, y, z)
    plane = mesh.facets_satisfying(lambda p: np.isclose(p[0], g.shaft_centre, atol=MERGE_DISTANCE))
    mesh = mesh.with_subdomains({"link": np.arange(mesh.nelements)})
    mesh = mesh.with_boundaries({"heated": plane, "cooled": mesh.boundary_facets()})
    sections = {"base": g.shaft_centre, "middle": g.shaft_centre + g.span / 2, "tip": g.diode_centre}
    weights = np.outer(_trapezoid(y), _trapezoid(z)).ravel()
    probes = {
        name: mean_at(mesh, np.stack(np.meshgrid([at], y, z, indexing="ij")).reshape(3, -1), weights)
        for name, at in sections.items()
    }
    middle, behind = (np.array([[at], [0.0], [0.0]]) for at in (g.shaft_centre, g.diode_centre))
    supports = (Support("heated", (0,)), Support(middle, (1, 2)), Support(behind, (1,)))
    return Body(mesh, {"link": material}, probes, probes["base"], probes["tip"], supports)


def paper_assembly(options: RodMesh = AS_DESCRIBED, materials: Mapping[str, Material] = MATERIALS) -> Body:
    """Build link, hollow shaft and laser diode as [1] V describes them.

    The outer surface of the shaft behind the link is heated (from `pad_gap` on), its far end fixed. Bore
    and far end are insulated; every other outer surface is cooled.
    """
    n, g = options.refinement, GEOMETRY
    through = np.linspace(0.0, g.thickness, n + 1)
    far = g.thickness - g.shaft_length
    # Seven elements along the shaft: one in the link, one in the gap if there is one, the rest heated.
    gap, along = ([-options.pad_gap], [5, 1, 1]) if options.pad_gap > 0 else ([], [6, 1])
    levels = {
        "link": through,
        "shaft": _lines([far, *gap, 0.0, g.thickness], along, n),
        "diode": _lines([0.0, g.thickness, g.diode_length], [1, 9], n),
    }
    if not options.diode:
        del levels["diode"]
    grids = _plan(n)
    mesh = _hexahedra((name, grid, level) for name, level in levels.items() for grid in grids[name])
    mesh = mesh.with_boundaries(_boundaries(mesh, options))
    r_s, r_d = g.shaft_diameter / 2, g.diode_diameter / 2
    front = {
        "base": (g.shaft_centre, r_s),
        "tip": (g.diode_centre, r_d),
        "beside_shaft": (g.shaft_centre + r_s, 0.0),
        "beside_diode": (g.diode_centre - r_d, 0.0),
    }
    probes = {name: mean_at(mesh, np.array([[x], [y], [g.thickness]])) for name, (x, y) in front.items()}
    probes["middle"] = _on_front(mesh, g.shaft_centre + g.span / 2, g.thickness)
    probes["base_ring"] = _around(mesh, (g.shaft_centre, r_s), through)
    probes["tip_ring"] = _around(mesh, (g.diode_centre, r_d), through)
    if options.diode:
        probes["diode"] = mean_at(mesh, np.array([[g.diode_centre], [0.0], [g.diode_length]]))
    origin, target = {
        "above": ("base_ring", "tip"),
        "centre": ("base_ring", "tip_ring"),
        "clear": ("beside_shaft", "beside_diode"),
    }[options.elongation_at]
    of = {name: materials[name] for name in levels}
    return Body(mesh, of, probes, probes[origin], probes[target], (Support("fixed"),))


def _boundaries(mesh: Any, options: RodMesh) -> dict[str, Any]:
    g, outer = GEOMETRY, mesh.boundary_facets()
    middle = mesh.p[:, mesh.facets[:, outer]].mean(axis=1)
    on_shaft, on_link = (np.isin(mesh.f2t[0, outer], mesh.subdomains[name]) for name in ("shaft", "link"))
    # A facet's mid point lies inside the circle through its nodes, never below cos(22.5 deg) of its radius.
    radius = np.hypot(middle[0] - g.shaft_centre, middle[1])
    bore = on_shaft & (radius <= g.shaft_bore / 2 * 1.0001)
    far_end = on_shaft & np.isclose(middle[2], g.thickness - g.shaft_length, atol=MERGE_DISTANCE * 2)
    side = on_shaft & (radius > g.shaft_diameter / 2 * 0.92)
    heated = side & (middle[2] < -options.pad_gap) & ~far_end
    cooled = on_link if options.only_link_cooled else ~(heated | far_end | bore)
    return {"heated": outer[heated], "fixed": outer[far_end], "cooled": outer[cooled]}


def _on_front(mesh: Any, x: float, z: float) -> Array:
    """The mean at x on the middle line of the front, between the two vertices beside it."""
    on_line = np.flatnonzero((np.abs(mesh.p[1]) < MERGE_DISTANCE) & (np.abs(mesh.p[2] - z) < MERGE_DISTANCE))
    on_line = on_line[np.argsort(mesh.p[0, on_line])]
    weights = [np.interp(x, mesh.p[0, on_line], unit) for unit in np.eye(len(on_line))]
    return mean_at(mesh, mesh.p[:, on_line], np.array(weights))


def _around(mesh: Any, hole: Circle, levels: Array) -> Array:
    """The mean over the eight nodes around a hole, by the trapezoidal rule over the levels."""
    circle = _circle(hole)[:-1].T
    points = np.concatenate([np.vstack([circle, np.full(8, z)]) for z in levels], axis=1)
    return mean_at(mesh, points, np.repeat(_trapezoid(levels), 8))


def _trapezoid(x: Array) -> Array:
    step = np.diff(x)
    return np.concatenate([[0.0], step]) + np.concatenate([step, [0.0]])


def _lines(at: Sequence[float], counts: Sequence[int], n: int) -> Array:
    """Grid lines through the given positions, with n times so many elements between each two."""
    pieces = [np.linspace(a, b, n * k + 1)[:-1] for a, b, k in zip(at[:-1], at[1:], counts, strict=True)]
    return np.concatenate([*pieces, [at[-1]]])


def _hexahedra(columns: Iterable[tuple[str, Array, Array]]) -> Any:
    """Extrude each grid, shape (n, m, 2) [m], over its levels [m] into one `skfem.MeshHex`, nodes merged.

    The names before the grids become its subdomains.
    """
    skfem = scikit_fem()
    points, cells, owner, count = [], [], [], 0
    for region, grid, levels in columns:
        block = skfem.MeshHex.init_tensor(*(np.arange(n) for n in (*grid.shape[:2], len(levels))))
        i, j, k = block.p.astype(int)
        points.append(np.vstack([grid[i, j].T, levels[k]]))
        cells.append(block.t + count)
        owner += [region] * block.nelements
        count += block.nvertices
    p = np.hstack(points)
    # The irrational shift keeps round dimensions away from the bins' edges.
    bins = np.floor(p / MERGE_DISTANCE + 1 / np.pi)
    _, first, node = np.unique(bins, axis=1, return_index=True, return_inverse=True)
    corners = node.reshape(-1)[np.hstack(cells)]
    mesh = skfem.MeshHex(np.ascontiguousarray(p[:, first]), np.ascontiguousarray(corners))
    return mesh.with_subdomains({name: np.flatnonzero(np.array(owner) == name) for name in set(owner)})


@cache
def _plan(n: int) -> dict[str, list[Array]]:
    """Grids of n x n elements, seen along the shaft: link without holes, shaft's ring, diode's disc."""
    g, half = GEOMETRY, GEOMETRY.width / 2
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
        "shaft": _ring(_circle(bore), _circle(shaft)),
        "diode": squares + _ring(edge, _circle(diode)),
    }
    circles = (shaft, bore, diode)
    return {name: [_grid(corners, circles, n) for corners in block] for name, block in blocks.items()}


def _circle(circle: Circle) -> Array:
    """Nine points around a circle, the last being the first, shape (9, 2)."""
    return _on_circle(circle, np.arange(9) * np.pi / 4)


def _on_circle(circle: Circle, angle: Array) -> Array:
    return np.array([circle[0], 0.0]) + circle[1] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _ring(near: Array, far: Array) -> list[Array]:
    return [np.array([near[i], far[i], far[i + 1], near[i + 1]]) for i in range(8)]


def _grid(corners: Array, circles: Sequence[Circle], n: int) -> Array:
    """Divide a quadrilateral into n x n by transfinite interpolation, shape (n + 1, n + 1, 2).

    Corners are anticlockwise, shape (4, 2); an edge with both ends on one of the circles is an arc of it.
    """
    s = np.linspace(0, 1, n + 1)
    c, u, v = corners, s[:, None, None], s[None, :, None]
    bottom, right, top, left = (_edge(c[i], c[(i + 1) % 4], circles, s) for i in range(4))
    bilinear = (1 - u) * (1 - v) * c[0] + u * (1 - v) * c[1] + u * v * c[2] + (1 - u) * v * c[3]
    across = (1 - v) * bottom[:, None] + v * top[::-1][:, None]
    return np.asarray(across + (1 - u) * left[::-1][None] + u * right[None] - bilinear)


def _edge(a: Array, b: Array, circles: Sequence[Circle], s: Array) -> Array:
    for circle in circles:
        out = np.array([a, b]) - (circle[0], 0.0)
        if np.allclose(np.hypot(*out.T), circle[1], rtol=0, atol=MERGE_DISTANCE):
            start, end = np.arctan2(*out.T[::-1])
            return _on_circle(circle, start + s * ((end - start + np.pi) % (2 * np.pi) - np.pi))
    return np.asarray(a + s[:, None] * (b - a))

"""Structured hexahedral meshes: a plain bar, and link with hollow shaft and laser diode.

[1] V gives 23 x 4 x 1 elements for the link, 7 along and 8 around the shaft, 10 along and 12 in the cross
section of the diode. These counts fit together without hanging nodes in one way, assumed here: a 2 x 2 block
of the link's elements makes room for each hole, the block's 8 edges being the 8 elements around; the diode's
section is 2 x 2 elements within a ring of 8.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.paper.data import Geometry, Material, Materials
from warmlink.orchestration.paper.fea.blocks import MERGE_DISTANCE, hexahedra, lines, plan
from warmlink.orchestration.paper.fea.library import scikit_fem


@dataclass(frozen=True)
class Probe:
    """A weighted mean over mesh vertices: `points`, shape (3, n) [m]; `weights`, shape (n,), of sum 1."""

    points: Array
    weights: Array

    @classmethod
    def mean(cls, points: Array) -> Probe:
        """Weigh all points, shape (3, n) [m], alike."""
        return cls(points, np.full(points.shape[1], 1 / points.shape[1]))


@dataclass(frozen=True)
class Support:
    """Holds the displacement along `axes` (0 to 2), on a named boundary or at vertices, shape (3, n) [m]."""

    where: str | Array
    axes: tuple[int, ...] = (0, 1, 2)


@dataclass(frozen=True)
class Body:
    """A mesh whose subdomains are materials and whose boundaries carry the boundary conditions.

    `mesh` is an `skfem.MeshHex` in metres, with the boundaries `heated` (temperature or heat flow prescribed;
    facets or a plane inside) and `cooled_<subdomain>` (free surfaces).
    `materials` maps subdomain to material. The mean temperature of each of the `probes` is reported under its
    name. The elongation is measured along x from `origin` to `target`.
    """

    mesh: Any
    materials: dict[str, Material]
    probes: dict[str, Probe]
    origin: Probe
    target: Probe
    supports: tuple[Support, ...]


def per_element(body: Body, *names: str) -> Array:
    """Product of material properties for each element of the body's mesh."""
    values = np.empty(body.mesh.nelements)
    for region, cells in body.mesh.subdomains.items():
        values[cells] = np.prod([getattr(body.materials[region], name) for name in names])
    return values


def vertices_at(mesh: Any, points: Array) -> NDArray[np.int64]:
    """Numbers of the mesh vertices at points, shape (3, n) [m]; InputError unless within a micrometre."""
    distance = np.linalg.norm(mesh.p[:, :, None] - points[:, None, :], axis=0)
    nearest = distance.argmin(axis=0)
    for point, gap in zip(points.T, distance.min(axis=0), strict=True):
        if gap > 1e-6:
            raise InputError(f"no mesh vertex at {point} m, the nearest is {gap:.3g} m off; choose a vertex")
    return np.asarray(nearest)


@dataclass(frozen=True)
class Assembly:
    """What is built around the link, beyond the geometry.

    `refinement` divides every element of the paper's mesh into that many along each direction. `pad_gap`
    [m] is the stretch of bare shaft between the link and the heated surface (the paper does not give it).
    `elongation_at` selects what is measured: `above`, from the shaft's centre to the edge of the diode's hole
    above the diode ([1] VI.B); `centre`, to the mean around that hole; `clear`, the link between the two
    holes.
    """

    refinement: int = 1
    pad_gap: float = 0.0
    diode: bool = True
    elongation_at: str = "above"


def bare_link(geometry: Geometry, materials: Materials, refinement: int = 1) -> Body:
    """Build the link alone, without holes, heated over its whole section at the shaft's centre.

    It is the 3-D counterpart of the 1-D link: what differs is width and thickness only. All faces are cooled.
    The elongation runs between the two sections.
    """
    skfem = scikit_fem()
    g = geometry
    counts = np.array([2, 20, 1]) * refinement
    x = lines([0.0, g.shaft_centre, g.diode_centre, g.length], counts)
    y = np.linspace(-g.width / 2, g.width / 2, 4 * refinement + 1)
    z = np.linspace(0, g.thickness, refinement + 1)
    mesh = skfem.MeshHex.init_tensor(x, y, z).with_subdomains(
        {"link": np.arange((len(x) - 1) * (len(y) - 1) * (len(z) - 1))}
    )
    plane = mesh.facets_satisfying(lambda p: np.isclose(p[0], g.shaft_centre, atol=MERGE_DISTANCE))
    names = {"heated": plane, "cooled_link": mesh.boundary_facets()}
    sections = {"base": g.shaft_centre, "middle": g.shaft_centre + g.span / 2, "tip": g.diode_centre}
    probes = {name: _section(at, y, z) for name, at in sections.items()}
    middle = np.array([[g.shaft_centre], [0.0], [0.0]])
    behind = np.array([[g.diode_centre], [0.0], [0.0]])
    supports = (Support("heated", (0,)), Support(middle, (1, 2)), Support(behind, (1,)))
    mesh = mesh.with_boundaries(names)
    return Body(mesh, {"link": materials.link}, probes, probes["base"], probes["tip"], supports)


def paper_assembly(geometry: Geometry, materials: Materials, options: Assembly | None = None) -> Body:
    """Build link, hollow shaft and laser diode as [1] V describes them.

    The outer surface of the shaft behind the link is heated (from `pad_gap` on), its far end fixed. Bore
    and far end are insulated; every other outer surface is cooled.
    """
    options = options or Assembly()
    n, g = options.refinement, geometry
    through = np.linspace(0.0, g.thickness, n + 1)
    levels = {
        "link": through,
        "shaft": _shaft_levels(g, options),
        "diode": lines([0.0, g.thickness, g.diode_length], np.array([1, 9]) * n),
    }
    if not options.diode:
        del levels["diode"]
    grids = plan(g, n)
    mesh = hexahedra((name, grid, level) for name, level in levels.items() for grid in grids[name])
    mesh = _with_names(mesh, g, options)
    materials_by_name = {name: getattr(materials, name) for name in mesh.subdomains}
    r_s, r_d = g.shaft_diameter / 2, g.diode_diameter / 2
    base = _point(g.shaft_centre, r_s, g.thickness)
    tip = _point(g.diode_centre, r_d, g.thickness)
    around_base = _ring(g.shaft_centre, r_s, through)
    around_tip = _ring(g.diode_centre, r_d, through)
    middle = _on_front(mesh, g.shaft_centre + g.span / 2, g.thickness)
    probes = {"base": base, "middle": middle, "tip": tip, "base_ring": around_base, "tip_ring": around_tip}
    if options.diode:
        probes["diode"] = _point(g.diode_centre, 0.0, g.diode_length)
    origin = around_base
    target = tip if options.elongation_at == "above" else around_tip
    if options.elongation_at == "clear":
        origin = _point(g.shaft_centre + r_s, 0.0, g.thickness)
        target = _point(g.diode_centre - r_d, 0.0, g.thickness)
    return Body(
        mesh=mesh,
        materials=materials_by_name,
        probes=probes,
        origin=origin,
        target=target,
        supports=(Support("fixed"),),
    )


def _shaft_levels(g: Geometry, options: Assembly) -> Array:
    """Seven elements along the shaft: one in the link, one in the gap if there is one, the rest heated."""
    far = g.thickness - g.shaft_length
    if options.pad_gap > 0:
        return lines([far, -options.pad_gap, 0.0, g.thickness], np.array([5, 1, 1]) * options.refinement)
    return lines([far, 0.0, g.thickness], np.array([6, 1]) * options.refinement)


def _with_names(mesh: Any, g: Geometry, options: Assembly) -> Any:
    """Name the boundaries of the assembly by where their facets lie."""
    outer = mesh.boundary_facets()
    middle = mesh.p[:, mesh.facets[:, outer]].mean(axis=1)
    owner = np.empty(mesh.nelements, dtype=object)
    for name, cells in mesh.subdomains.items():
        owner[cells] = name
    region = owner[mesh.f2t[0, outer]]
    # A facet's mid point lies inside the circle through its nodes, never below cos(22.5 deg) of its radius.
    radius = np.hypot(middle[0] - g.shaft_centre, middle[1])
    on_shaft = region == "shaft"
    bore = on_shaft & (radius <= g.shaft_bore / 2 * 1.0001)
    far_end = on_shaft & np.isclose(middle[2], g.thickness - g.shaft_length, atol=MERGE_DISTANCE * 2)
    side = on_shaft & (radius > g.shaft_diameter / 2 * 0.92)
    heated = side & (middle[2] < -options.pad_gap) & ~far_end
    names = {"heated": outer[heated], "fixed": outer[far_end]}
    free = ~(heated | far_end | bore)
    names |= {f"cooled_{name}": outer[free & (region == name)] for name in mesh.subdomains}
    return mesh.with_boundaries(names)


def _point(x: float, y: float, z: float) -> Probe:
    return Probe.mean(np.array([[x], [y], [z]]))


def _on_front(mesh: Any, x: float, z: float) -> Probe:
    """The point at x on the middle line of the front, between the two vertices beside it."""
    on_line = np.flatnonzero((np.abs(mesh.p[1]) < MERGE_DISTANCE) & (np.abs(mesh.p[2] - z) < MERGE_DISTANCE))
    on_line = on_line[np.argsort(mesh.p[0, on_line])]
    after = int(np.searchsorted(mesh.p[0, on_line], x))
    pair = mesh.p[:, on_line[after - 1 : after + 1]]
    share = (x - pair[0, 0]) / (pair[0, 1] - pair[0, 0])
    return Probe(pair, np.array([1 - share, share]))


def _section(x: float, y: Array, z: Array) -> Probe:
    """The mean over a section at x, by the trapezoidal rule on its grid lines."""
    yy, zz = np.meshgrid(y, z, indexing="ij")
    weights = np.outer(_trapezoid(y), _trapezoid(z)).ravel()
    return Probe(np.stack([np.full(yy.size, x), yy.ravel(), zz.ravel()]), weights / weights.sum())


def _trapezoid(x: Array) -> Array:
    step = np.diff(x)
    return np.concatenate([[0.0], step]) + np.concatenate([step, [0.0]])


def _ring(x: float, radius: float, levels: Array) -> Probe:
    """The mean over the eight nodes around a hole, by the trapezoidal rule over the levels."""
    angle = np.arange(8) * np.pi / 4
    circle = np.stack([x + radius * np.cos(angle), radius * np.sin(angle)])
    points = np.concatenate([np.vstack([circle, np.full(8, z)]) for z in levels], axis=1)
    weights = np.repeat(_trapezoid(levels), 8)
    return Probe(points, weights / weights.sum())

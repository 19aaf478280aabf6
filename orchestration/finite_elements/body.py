"""A body of several materials in finite elements: its heat equation and its thermo-elasticity in matrices.

sigma = 2 mu eps + lambda tr(eps) I - (3 lambda + 2 mu) alpha (T - T_ref) I, div sigma = 0, for an expansion
coefficient alpha and Lame parameters lambda and mu (K.-J. Bathe, *Finite Element Procedures*, 2014).

Fully integrated 8-node hexahedra, one through the thickness, lock in bending, so the displacement uses
20-node serendipity elements on the same mesh by default; they contain pure bending exactly. `order=1` gives
8-node ones, as the temperatures have.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import bmat, csc_matrix, csr_matrix, diags, vstack
from scipy.sparse.linalg import splu

from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.fmus.thermal_link.equations import STEFAN_BOLTZMANN
from warmlink.orchestration.arrays import Array


@dataclass(frozen=True)
class Material:
    """Properties of one material in SI units; `source` says where they are from."""

    name: str
    source: str
    conductivity: float
    density: float
    specific_heat: float
    youngs_modulus: float
    poissons_ratio: float
    expansion_coefficient: float
    emissivity: float

    @property
    def diffusivity(self) -> float:
        """Thermal diffusivity k / (rho c) [m2/s]."""
        return self.conductivity / (self.density * self.specific_heat)


@dataclass(frozen=True)
class Support:
    """Holds the displacement along `axes` (0 to 2), on a named boundary or at vertices, shape (3, n) [m]."""

    where: str | Array
    axes: tuple[int, ...] = (0, 1, 2)


@dataclass(frozen=True)
class Body:
    """A mesh whose subdomains are materials and whose boundaries carry the boundary conditions.

    `mesh` is an `skfem.MeshHex` in m, with the boundaries `heated` (temperature or heat flow prescribed; also
    a plane inside) and `cooled`. The mean temperature by each of the `probes` is reported under its name. The
    elongation is measured along x from `origin` to `target`; these and the probes are rows of `mean_at`.
    """

    mesh: Any
    materials: dict[str, Material]
    probes: dict[str, Array]
    origin: Array
    target: Array
    supports: tuple[Support, ...]

    def property(self, name: str) -> Array:
        """Property of the material of each element."""
        values = np.empty(self.mesh.nelements)
        for region, cells in self.mesh.subdomains.items():
            values[cells] = getattr(self.materials[region], name)
        return values


def vertices_at(mesh: Any, points: Array) -> NDArray[np.int64]:
    """Numbers of the mesh vertices at points, shape (3, n) [m]; InputError unless within a micrometre."""
    distance = np.linalg.norm(mesh.p[:, :, None] - points[:, None, :], axis=0)
    nearest = distance.argmin(axis=0)
    for point, gap in zip(points.T, distance.min(axis=0), strict=True):
        if gap > 1e-6:
            raise InputError(f"no mesh vertex at {point} m, the nearest is {gap:.3g} m off; choose a vertex")
    return np.asarray(nearest)


def mean_at(mesh: Any, points: Array, weights: Array | None = None) -> Array:
    """Row that gives the mean over vertices at points, shape (3, n) [m], from values at all vertices."""
    row = np.zeros(mesh.nvertices)
    np.add.at(row, vertices_at(mesh, points), 1.0 if weights is None else weights)
    return np.asarray(row / row.sum())


class HeatModel:
    """C dT/dt + (K + h B) T = h b T_a + q Q - r(T) on 8-node trilinear hexahedra with n nodes, its `size`.

    `capacity` C [J/K], `conduction` K [W/K] and `convection` B [m2] are of shape (n, n). `load` b is the
    cooled area of each node [m2], `heated_load` q how 1 W, spread evenly over the heated boundary, falls on
    the nodes. `points`, shape (points, n), gives values at the cooled surface's quadrature points, each with
    an `area` [m2] and an `emissivity`.
    """

    def __init__(self, body: Body) -> None:
        skfem = scikit_fem()
        self.body, mesh = body, body.mesh
        self.basis = skfem.Basis(mesh, skfem.ElementHex1(), intorder=3)
        self.size = int(self.basis.N)
        self.capacity = mass(self.basis, body.property("density") * body.property("specific_heat"))
        self.conduction = conduction(self.basis, body.property("conductivity"))
        self.heated_nodes = np.unique(mesh.facets[:, mesh.boundaries["heated"]])
        heated, area, _ = self._quadrature("heated")
        self.heated_load = heated.T @ area / area.sum()
        self.points, self.area, self.emissivity = self._quadrature("cooled")
        self.load = self.points.T @ self.area
        self.convection = csc_matrix(self.points.T @ diags(self.area) @ self.points)

    def radiant_load(self, temperature: Array, ambient: float) -> Array:
        """Radiation loss distributed on the nodes [W]: e s (T^4 - T_a^4), a grey body in a black room."""
        flux = self.emissivity * STEFAN_BOLTZMANN * ((self.points @ temperature) ** 4 - ambient**4)
        return np.asarray(self.points.T @ (self.area * flux))

    def radiant_matrix(self, temperature: float) -> csr_matrix:
        """Derivative of `radiant_load` at one temperature [K] everywhere, [W/K]."""
        weight = 4 * STEFAN_BOLTZMANN * temperature**3 * self.emissivity * self.area
        return csr_matrix(self.points.T @ diags(weight) @ self.points)

    def _quadrature(self, boundary: str) -> tuple[csr_matrix, Array, Array]:
        """Values at the quadrature points from those of the nodes, and areas and emissivities."""
        mesh, facets = self.body.mesh, self.body.mesh.boundaries[boundary]
        basis = scikit_fem().FacetBasis(mesh, self.basis.elem, facets=facets, intorder=3)
        shapes = np.array([np.broadcast_to(shape, basis.dx.shape) for (shape,) in basis.basis])
        points = np.broadcast_to(np.arange(basis.dx.size).reshape(basis.dx.shape), shapes.shape)
        nodes = np.broadcast_to(basis.element_dofs[:, :, None], shapes.shape)
        entries = shapes.ravel(), (points.ravel(), nodes.ravel())
        emissivity = self.body.property("emissivity")[mesh.f2t[0, facets]]
        return (
            csr_matrix(entries, shape=(basis.dx.size, self.size)),
            basis.dx.ravel(),
            np.repeat(emissivity, basis.dx.shape[1]),
        )


class ThermoElasticity:
    """Elastic equilibrium of a body; displacement on 8 nodes of a hexahedron (`order` 1) or 20 (2).

    `elongation_row` gives the elongation [m] from nodal T - T_ref [K]: an adjoint solution.
    """

    def __init__(self, body: Body, order: int = 2) -> None:
        skfem = scikit_fem()
        if order not in (1, 2):
            raise InputError(f"order: {order} is neither 1 (8-node) nor 2 (20-node)")
        self.body = body
        element = skfem.ElementHex1() if order == 1 else skfem.ElementHexS2()
        basis = skfem.Basis(body.mesh, element, intorder=3 if order == 1 else 5)
        elastic = body.property("youngs_modulus"), body.property("poissons_ratio")
        self._count, self._vertices = basis.N, np.asarray(basis.nodal_dofs[0])
        held = np.concatenate([self._held(basis, support) for support in body.supports])
        self._free = np.setdiff1d(np.arange(3 * basis.N), held)
        free = stiffness(basis, *elastic)[self._free][:, self._free]
        # With 20-node elements COLAMD fills in less, and takes half the time.
        self._factor = symmetric_factor(free) if order == 1 else splu(free, permc_spec="COLAMD")
        heat = basis.with_element(skfem.ElementHex1())
        self._load = thermal_load(heat, basis, *elastic, body.property("expansion_coefficient"))
        wanted = np.zeros(3 * basis.N)
        wanted[self._vertices] = body.target - body.origin
        self.elongation_row = np.asarray(self._load.T @ self._solve(wanted))

    def displacement(self, rise: Array) -> Array:
        """Displacement of the mesh's vertices, shape (3, n) [m], for nodal T - T_ref [K], shape (n,)."""
        return np.asarray(self._solve(self._load @ rise).reshape(3, -1)[:, self._vertices])

    def _solve(self, forces: Array) -> Array:
        found = np.zeros_like(forces)
        found[self._free] = self._factor.solve(forces[self._free])
        return found

    def _held(self, basis: Any, support: Support) -> NDArray[np.int64]:
        mesh = self.body.mesh
        if isinstance(support.where, str):
            scalar = basis.get_dofs(mesh.boundaries[support.where]).all()
        else:
            scalar = self._vertices[vertices_at(mesh, support.where)]
        return np.concatenate([np.asarray(scalar) + axis * self._count for axis in support.axes])


def scikit_fem() -> ModuleType:
    """Return the module `skfem`, or say that it is missing."""
    try:
        import skfem
    except ImportError as error:
        raise MissingExtraError("the 3-D finite-element model", "fea") from error
    return skfem


def symmetric_factor(matrix: Any) -> Any:
    """Factorise a matrix that is symmetric and definite, and tell SuperLU so."""
    return splu(
        csc_matrix(matrix),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )


def mass(basis: Any, weight: ArrayLike = 1.0) -> csc_matrix:
    """Integral of a weight times the product of two temperatures; over facets for a basis of facets."""
    return _assembled(lambda u, v, w: w.weight * u * v, basis, weight=weight)


def conduction(basis: Any, conductivity: ArrayLike = 1.0) -> csc_matrix:
    """Integral of the conductivity times the product of two gradients."""
    return _assembled(lambda u, v, w: w.k * _products(u, v), basis, k=conductivity)


def stiffness(basis: Any, modulus: ArrayLike, ratio: ArrayLike) -> csc_matrix:
    """Integral of 2 mu eps(u) : eps(v) + lambda div u div v, from Young's modulus and Poisson's ratio.

    The displacement's component a at scalar unknown n of N is unknown n + a N. Each pair of components is a
    scalar form: a vector-valued one takes far longer to assemble.
    """
    first, second = _lame(modulus, ratio)
    blocks: list[list[Any]] = [[None] * 3 for _ in range(3)]
    for a, b in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):

        def strain(u: Any, v: Any, w: Any, a: int = a, b: int = b) -> Any:
            mixed = w.first * u.grad[b] * v.grad[a] + w.second * u.grad[a] * v.grad[b]
            return mixed + w.second * _products(u, v) if a == b else mixed

        blocks[a][b] = _assembled(strain, basis, first=first, second=second)
        blocks[b][a] = blocks[a][b].T
    return csc_matrix(bmat(blocks))


def thermal_load(
    heat: Any, basis: Any, modulus: ArrayLike, ratio: ArrayLike, expansion: ArrayLike = 1.0
) -> csc_matrix:
    """Forces of the displacement's basis from T - T_ref in the basis of the temperatures."""
    first, second = _lame(modulus, ratio)
    stress = (3 * first + 2 * second) * np.asarray(expansion)
    forces = [
        _assembled(lambda t, v, w, a=a: w.stress * t * v.grad[a], heat, basis, stress=stress)
        for a in range(3)
    ]
    return csc_matrix(vstack(forces))


def _lame(modulus: ArrayLike, ratio: ArrayLike) -> tuple[Any, Any]:
    from skfem.models.elasticity import lame_parameters

    found: tuple[Any, Any] = lame_parameters(np.asarray(modulus), np.asarray(ratio))
    return found


def _products(u: Any, v: Any) -> Any:
    return u.grad[0] * v.grad[0] + u.grad[1] * v.grad[1] + u.grad[2] * v.grad[2]


def _assembled(form: Any, *bases: Any, **properties: ArrayLike) -> csc_matrix:
    """Assemble a form; properties are numbers, or arrays with one for each element."""
    shape = bases[0].dx.shape
    at_points = {
        name: np.broadcast_to(np.asarray(value)[..., None], shape) for name, value in properties.items()
    }
    return csc_matrix(scikit_fem().BilinearForm(form).assemble(*bases, **at_points))

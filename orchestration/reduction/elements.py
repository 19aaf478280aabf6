"""Heat and thermo-elastic equilibrium of a part by quadratic tetrahedra.

    c M dT/dt + (k K + sum of h_g B_g) T = loads,    tool motion = alpha D (T - T_ref)

The motion of the tool's face relative to the heated face is one linear functional of the temperatures: an
adjoint elastic solution, tested with the thermal load (K.-J. Bathe, *Finite Element Procedures*, 2014, on the
elements). Stresses in a body of one material do not depend on its modulus of elasticity, only on Poisson's
ratio.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import block_diag, bmat, csc_matrix, csr_matrix, vstack

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.reduction.equilibrium import Equilibrium, linear_to_quadratic
from warmlink.orchestration.reduction.simplices import nearest
from warmlink.orchestration.reduction.solid import Face, Solid


@dataclass(frozen=True, eq=False)
class Task:
    """What of a part is heated, carries the tool, is cooled and is measured.

    Attributes
    ----------
    heated : faces that heat enters evenly, and to which motion is relative
    tool : faces whose motion the tool follows
    cooled : groups of faces, each with its own convection
    tool_point : [m]
    sensors : places of the eight thermometers, shape (8, 3) [m]
    poissons_ratio : of the material
    """

    heated: Sequence[Face]
    tool: Sequence[Face]
    cooled: Sequence[Sequence[Face]]
    tool_point: Array
    sensors: Array
    poissons_ratio: float = 0.33


@dataclass(frozen=True, eq=False)
class HeatMatrices:
    """A part in N temperatures: matrices for a material of unit properties, loads and outputs.

    Attributes
    ----------
    mass, conduction : shape (N, N)
    cooling : one of shape (N, N) for each cooled group
    loads : of 1 W at base and tip and 1 W/m2 on each group, shape (N, 2 + G)
    motion : displacement and rotation of the tool for an expansion coefficient of 1, shape (6, N)
    sensors : shape (8, N)
    places : of the temperatures, shape (3, N) [m]
    reach : from the middle of the heated face to the tool point, shape (3,) [m]
    """

    mass: csc_matrix
    conduction: csc_matrix
    cooling: tuple[csc_matrix, ...]
    loads: Array
    motion: Array
    sensors: Array
    places: Array
    reach: Array

    @property
    def unknowns(self) -> int:
        """Number of temperatures N."""
        return int(self.mass.shape[0])

    @property
    def outputs(self) -> Array:
        """Rows of motion, sensors, and the mean temperatures of base and tip, shape (16, N)."""
        return np.vstack([self.motion, self.sensors, self.loads[:, :2].T])


class Elements:
    """Finite elements of a part for a task.

    Attributes
    ----------
    heat : matrices of its temperatures, and the tool's motion
    """

    def __init__(self, solid: Solid, task: Task) -> None:
        import skfem

        mesh, element = solid.mesh, skfem.ElementTetP2()
        basis = skfem.Basis(mesh, element, intorder=2)
        surfaces = {
            name: _Surface(skfem.FacetBasis(mesh, element, facets=solid.facets(faces), intorder=4))
            for name, faces in (("base", task.heated), ("tip", task.tool), *enumerate(task.cooled))
        }
        groups = [surfaces[g] for g in range(len(task.cooled))]
        base, tip = surfaces["base"], surfaces["tip"]
        places = np.asarray(basis.doflocs)
        centre = places @ base.load / base.area
        product = _gradient_products(basis)
        conduction = product[0][0] + product[1][1] + product[2][2]
        self._rigid = _rigid_motions(places, centre)
        self._motion_of_base = _rigid_part(base.mass, places, centre)
        motion_of_tip = _rigid_part(tip.mass, places, task.tool_point)
        # The heated face's motion, carried to the tool point, is what is not the tool's own.
        wanted = motion_of_tip - (motion_of_tip @ self._rigid.T) @ self._motion_of_base
        self._elastic = Equilibrium(_stiffness(product, conduction, task.poissons_ratio), self._rigid, basis)
        self._forces = _thermal_load(basis, task.poissons_ratio)
        self.heat = HeatMatrices(
            mass=csc_matrix(_mass(skfem.Basis(mesh, element, intorder=4))),
            conduction=csc_matrix(conduction),
            cooling=tuple(csc_matrix(group.mass) for group in groups),
            loads=np.stack(
                [base.load / base.area, tip.load / tip.area, *(group.load for group in groups)], axis=1
            ),
            motion=np.asarray(self._elastic.solve(wanted) @ self._forces),
            sensors=np.array([_temperature_at(place, basis) for place in task.sensors]),
            places=places,
            reach=task.tool_point - centre,
        )

    def displacements(self, rises: Array) -> Array:
        """Displacements relative to the heated face for an expansion coefficient of 1.

        Parameters
        ----------
        rises : of the temperatures, shape (n, N) [K]

        Returns
        -------
        numpy.ndarray
            Shape (n, 3, N) [m].
        """
        found = self._elastic.solve((self._forces @ rises.T).T)
        found = found - (found @ self._motion_of_base.T) @ self._rigid
        return found.reshape(len(rises), 3, -1)


def linear_temperatures(heat: HeatMatrices, solid: Solid) -> HeatMatrices:
    """Matrices for temperatures that are linear in each tetrahedron of the same mesh."""
    import skfem

    spread = linear_to_quadratic(skfem.Basis(solid.mesh, skfem.ElementTetP2(), intorder=1))
    return replace(
        heat,
        mass=csc_matrix(spread.T @ heat.mass @ spread),
        conduction=csc_matrix(spread.T @ heat.conduction @ spread),
        cooling=tuple(csc_matrix(spread.T @ each @ spread) for each in heat.cooling),
        loads=spread.T @ heat.loads,
        motion=heat.motion @ spread,
        sensors=heat.sensors @ spread,
    )


class _Surface:
    """Mass matrix, load and area of some facets."""

    def __init__(self, basis: Any) -> None:
        self.mass = _mass(basis)
        self.load = np.asarray(self.mass.sum(axis=0)).ravel()
        self.area = float(self.load.sum())


def _mass(basis: Any) -> csr_matrix:
    from skfem.models.poisson import mass

    return csr_matrix(mass.assemble(basis))


def _gradient_products(basis: Any) -> list[list[csr_matrix]]:
    """Integrals of the derivative of test functions along axis a times that of trial functions along c."""
    from skfem import BilinearForm

    def product(a: int, c: int) -> csr_matrix:
        return csr_matrix(BilinearForm(lambda u, v, w: v.grad[a] * u.grad[c]).assemble(basis))

    return [[product(a, c) for c in range(3)] for a in range(3)]


def _lame(ratio: float) -> tuple[float, float]:
    """Lame parameters lambda and mu for a modulus of elasticity of 1."""
    return ratio / ((1 + ratio) * (1 - 2 * ratio)), 1 / (2 * (1 + ratio))


def _stiffness(product: list[list[csr_matrix]], laplacian: csr_matrix, ratio: float) -> csr_matrix:
    """Integral of 2 mu eps(u) : eps(v) + lambda div u div v; displacements along x first, then y and z."""
    first, second = _lame(ratio)
    blocks = [
        [
            first * product[a][c] + second * product[c][a] + (second * laplacian if a == c else 0)
            for c in range(3)
        ]
        for a in range(3)
    ]
    return csr_matrix(bmat(blocks))


def _thermal_load(basis: Any, ratio: float) -> csr_matrix:
    """Forces from temperatures for an expansion coefficient of 1, shape (3 N, N)."""
    from skfem import BilinearForm

    first, second = _lame(ratio)

    def force(axis: int) -> csr_matrix:
        return csr_matrix(BilinearForm(lambda u, v, w: v.grad[axis] * u).assemble(basis))

    return csr_matrix((3 * first + 2 * second) * vstack([force(axis) for axis in range(3)]))


def _rigid_motions(places: Array, centre: Array) -> Array:
    """Displacements of all places by the six unit motions about a centre, shape (6, 3 N)."""
    x, y, z = places - centre[:, None]
    motions = np.zeros((6, 3, places.shape[1]))
    motions[[0, 1, 2], [0, 1, 2]] = 1.0
    motions[3, 1:], motions[4, ::2], motions[5, :2] = (-z, y), (z, -x), (-y, x)
    return motions.reshape(6, -1)


def _rigid_part(mass: csr_matrix, places: Array, centre: Array) -> Array:
    """Rows that give a face's rigid motion about a centre, by least squares over its area, shape (6, 3 N)."""
    motions = _rigid_motions(places, centre)
    weighted = (block_diag([mass] * 3) @ motions.T).T
    return np.asarray(np.linalg.solve(motions @ weighted.T, weighted))


def _temperature_at(place: Array, basis: Any) -> Array:
    """Row that gives the temperature at the place in the part that is nearest to a point."""
    found = nearest(place, basis.mesh.p[:, basis.mesh.t])
    row = np.zeros(basis.N)
    for i, dof in enumerate(basis.element_dofs[:, found.cell]):
        row[dof] += basis.elem.lbasis(found.weights[1:], i)[0]
    return row

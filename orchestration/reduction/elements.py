"""Heat and thermo-elastic equilibrium of a part by quadratic tetrahedra.

    c M dT/dt + (k K + sum of h_g B_g) T = loads,    tool motion = alpha D (T - T_ref)

The motion of the tool's face relative to the heated face is one linear functional of the temperatures: an
adjoint elastic solution, tested with the thermal load. Stresses in a body of one material do not depend on
its modulus of elasticity, only on Poisson's ratio.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import qr
from scipy.sparse import block_diag, csc_matrix, csr_matrix
from scipy.sparse.linalg import LinearOperator, cg

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.finite_elements.forms import (
    conduction,
    mass,
    stiffness,
    symmetric_factor,
    thermal_load,
)
from warmlink.orchestration.reduction.solid import Face, Solid
from warmlink.orchestration.reduction.surface import nearest

TOLERANCE, MOST_ITERATIONS = 1e-9, 1000
"""Of the conjugate gradients: relative residual, and when they are given up."""


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
class Heat:
    """A part's heat in n temperatures, or n patterns: matrices for a material of unit properties.

    Attributes
    ----------
    mass, conduction : shape (n, n)
    integrals : of each over the part, shape (n,) [m3]
    cooling : one of shape (n, n) for each cooled group
    loads : of 1 W at base and tip and 1 W/m2 on each group, shape (n, 2 + G)
    outputs : displacement and rotation of the tool for an expansion coefficient of 1, the temperatures of
        the eight sensors, and the mean ones of base and tip, shape (16, n)
    reach : from the middle of the heated face to the tool point, shape (3,) [m]
    """

    mass: Any
    conduction: Any
    integrals: Array
    cooling: Sequence[Any]
    loads: Array
    outputs: Array
    reach: Array

    @property
    def unknowns(self) -> int:
        """Number of temperatures n."""
        return len(self.loads)

    def onto(self, basis: Any) -> Heat:
        """The same in amplitudes of the columns of a basis, shape (n, m) (Galerkin's projection)."""
        return replace(
            self,
            mass=basis.T @ (self.mass @ basis),
            conduction=basis.T @ (self.conduction @ basis),
            integrals=basis.T @ self.integrals,
            cooling=[basis.T @ (each @ basis) for each in self.cooling],
            loads=basis.T @ self.loads,
            outputs=self.outputs @ basis,
        )


class Elements:
    """Finite elements of a part for a task.

    Attributes
    ----------
    heat : matrices of its temperatures, and the tool's motion
    places : of the temperatures, shape (3, N) [m]
    """

    def __init__(self, solid: Solid, task: Task) -> None:
        import skfem

        mesh, element, ratio = solid.mesh, skfem.ElementTetP2(), task.poissons_ratio
        basis = skfem.Basis(mesh, element, intorder=2)
        base, tip, *groups = (
            mass(skfem.FacetBasis(mesh, element, facets=solid.facets(faces), intorder=4))
            for faces in (task.heated, task.tool, *task.cooled)
        )
        loads = np.stack([np.asarray(each.sum(axis=0)).ravel() for each in (base, tip, *groups)], axis=1)
        loads[:, :2] /= loads[:, :2].sum(axis=0)
        places = np.asarray(basis.doflocs)
        centre = places @ loads[:, 0]
        self._rigid = _rigid_motions(places, centre)
        self._motion_of_base = _rigid_part(base, places, centre)
        motion_of_tip = _rigid_part(tip, places, task.tool_point)
        # The heated face's motion, carried to the tool point, is what is not the tool's own.
        wanted = motion_of_tip - (motion_of_tip @ self._rigid.T) @ self._motion_of_base
        self._elastic = Equilibrium(stiffness(basis, 1.0, ratio), self._rigid, basis)
        self._forces = thermal_load(basis, basis, 1.0, ratio)
        motion = np.asarray(self._elastic.solve(wanted) @ self._forces)
        sensors = np.array([_temperature_at(place, basis) for place in task.sensors])
        self.places = places
        stored = mass(skfem.Basis(mesh, element, intorder=4))
        self.heat = Heat(
            mass=stored,
            conduction=conduction(basis),
            integrals=np.asarray(stored.sum(axis=0)).ravel(),
            cooling=groups,
            loads=loads,
            outputs=np.vstack([motion, sensors, loads[:, :2].T]),
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


class Equilibrium:
    """Elastic equilibrium of a body that nothing holds, under forces in balance.

    These do no work in a rigid motion, so that six unknowns may be held without a reaction. Conjugate
    gradients in two levels: the preconditioner smooths by the sums of the rows, and solves exactly for
    displacements that are linear in each element (Y. Saad, *Iterative Methods for Sparse Linear Systems*,
    2nd ed., SIAM 2003, section 13.4).

    Parameters
    ----------
    matrix : stiffness, shape (3 N, 3 N), displacements along x first, then y and z
    rigid : the six rigid motions, shape (6, 3 N)
    basis : quadratic scalar `skfem.Basis` with N unknowns
    """

    def __init__(self, matrix: csc_matrix, rigid: Array, basis: Any) -> None:
        size, corners = basis.N, np.asarray(basis.nodal_dofs[0])
        candidates = np.concatenate([corners + axis * size for axis in range(3)])
        scale = np.abs(rigid).max(axis=1)[:, None]
        _, _, order = qr(rigid[:, candidates] / scale, pivoting=True, mode="economic")
        self._free = np.setdiff1d(np.arange(3 * size), candidates[order[:6]])
        self._matrix = csr_matrix(matrix[self._free][:, self._free])
        kept = np.flatnonzero(np.isin(candidates, self._free))
        self._coarse = csr_matrix(block_diag([linear_to_quadratic(basis)] * 3))[self._free][:, kept]
        self._factor = symmetric_factor(self._coarse.T @ self._matrix @ self._coarse)
        self._smooth = 1 / np.asarray(abs(self._matrix).sum(axis=1)).ravel()

    def solve(self, forces: Array) -> Array:
        """Displacements under forces in balance, six of them held at 0, shape (m, 3 N).

        With rows that give motions from displacements, and do not see rigid ones, in place of the forces:
        the adjoint solutions, whose work with any forces in balance is the motion.

        Parameters
        ----------
        forces : shape (m, 3 N)
        """
        found = np.zeros_like(forces)
        about = LinearOperator(self._matrix.shape, self._approximate)
        for row, target in zip(found, forces[:, self._free], strict=True):
            row[self._free], failed = cg(
                self._matrix, target, rtol=TOLERANCE, maxiter=MOST_ITERATIONS, M=about
            )
            if failed:
                raise InputError(
                    f"the elastic equations were not solved in {MOST_ITERATIONS} iterations, as with "
                    "elements that are all but flat; give another --mesh-size"
                )
        return found

    def _approximate(self, residual: Array) -> Array:
        found = self._smooth * residual
        found = found + self._coarse @ self._factor.solve(self._coarse.T @ (residual - self._matrix @ found))
        return found + self._smooth * (residual - self._matrix @ found)


def linear_to_quadratic(basis: Any) -> csr_matrix:
    """Values at corners and middles of edges from those at the corners, shape (N, corners)."""
    corners, middles, ends = basis.nodal_dofs[0], basis.edge_dofs[0], basis.mesh.edges
    count = len(corners)
    rows = np.concatenate([corners, middles, middles])
    columns = np.concatenate([np.arange(count), ends[0], ends[1]])
    weights = np.concatenate([np.ones(count), np.full(2 * len(middles), 0.5)])
    return csr_matrix((weights, (rows, columns)), shape=(basis.N, count))


def linear_temperatures(heat: Heat, solid: Solid) -> Heat:
    """Matrices for temperatures that are linear in each tetrahedron of the same mesh."""
    import skfem

    return heat.onto(linear_to_quadratic(skfem.Basis(solid.mesh, skfem.ElementTetP2(), intorder=1)))


def _rigid_motions(places: Array, centre: Array) -> Array:
    """Displacements of all places by the six unit motions about a centre, shape (6, 3 N)."""
    x, y, z = places - centre[:, None]
    motions = np.zeros((6, 3, places.shape[1]))
    motions[[0, 1, 2], [0, 1, 2]] = 1.0
    motions[3, 1:], motions[4, ::2], motions[5, :2] = (-z, y), (z, -x), (-y, x)
    return motions.reshape(6, -1)


def _rigid_part(weights: csc_matrix, places: Array, centre: Array) -> Array:
    """Rows that give a face's rigid motion about a centre, by least squares over its area, shape (6, 3 N)."""
    motions = _rigid_motions(places, centre)
    weighted = (block_diag([weights] * 3) @ motions.T).T
    return np.asarray(np.linalg.solve(motions @ weighted.T, weighted))


def _temperature_at(place: Array, basis: Any) -> Array:
    """Row that gives the temperature at the place in the part that is nearest to a point."""
    found = nearest(place, basis.mesh.p[:, basis.mesh.t])
    row = np.zeros(basis.N)
    for i, dof in enumerate(basis.element_dofs[:, found.cell]):
        row[dof] += basis.elem.lbasis(found.weights[1:], i)[0]
    return row

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

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.thermal_link.equations import SENSOR_SHARES, SENSORS
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.finite_elements import body as fem
from warmlink.orchestration.reduction.places import nearest
from warmlink.orchestration.reduction.solid import Face, Solid, point

LEAST_REACH = 1e-5
"""m from the middle of the heated face to the tool point, along which a link grows."""

TOLERANCE, MOST_ITERATIONS = 1e-9, 1000
"""Of the conjugate gradients: relative residual, and when they are given up."""


@dataclass(frozen=True)
class Use:
    """How a part is used, in the words of the command (see `Solid.chosen` and `point`).

    Heat enters the `heated` faces evenly, and motion is relative to them. The tool follows the faces `tool`,
    by default the one nearest to the tool point. `cooled` are groups of faces, parted by `;`, by default all
    but the heated ones; `sensors` up to eight thermometers, the others as ThermalLink's.
    """

    heated: Sequence[str]
    tool_point: str
    tool: Sequence[str] = ()
    cooled: Sequence[str] = ()
    sensors: Sequence[str] = ()
    poissons_ratio: float = 0.33

    def faces(self, solid: Solid) -> tuple[list[Face], ...]:
        """Faces heated, of the tool, and of each cooled group; InputError where one is used twice."""
        heated = solid.chosen(self.heated, "heat_faces")
        place = point(self.tool_point, "tool_point")
        tool = solid.chosen(self.tool, "tool_faces") or [solid.nearest(place)]
        if not {*tool}.isdisjoint(heated):
            raise InputError(
                f"{argument('tool_point', self.tool_point)}: lies on the heated face, to which motion is "
                f"relative; give a point on another face, or {argument('tool_faces')}"
            )
        groups = [solid.chosen(text.split(";"), "cooled") for text in self.cooled]
        numbers = [face.number for group in groups for face in group]
        if len({*numbers}) < len(numbers):
            twice = max(numbers, key=numbers.count)
            raise InputError(f"{argument('cooled')}: face #{twice} is named twice; name it once")
        return heated, tool, *(groups or [[face for face in solid.faces if face not in heated]])

    def places(self, base: Array) -> tuple[Array, Array]:
        """Tool point and thermometers [m], shapes (3,) and (8, 3), for the middle of the heated face.

        InputError where one is no such place.
        """
        if len(self.sensors) > SENSORS:
            raise InputError(
                f"{argument('sensor_points')}: {len(self.sensors)} are given; a link has {SENSORS}"
            )
        tool = point(self.tool_point, "tool_point")
        if np.linalg.norm(tool - base) < LEAST_REACH:
            raise InputError(
                f"{argument('tool_point', self.tool_point)}: is the middle of the heated face, from "
                "which no direction leads to it; give another point"
            )
        given = [point(text, "sensor_points") for text in self.sensors]
        return tool, np.array([*given, *(base + np.outer(SENSOR_SHARES, tool - base))[len(given) :]])


@dataclass(frozen=True, eq=False)
class Heat:
    """A part's heat in n temperatures, or n patterns: matrices for a material of unit properties.

    `mass`, `conduction` and one `cooling` for each group are of shape (n, n); `integrals` are those of each
    pattern over the part, shape (n,) [m3]; `loads`, `outputs` and `reach` are as `ReducedModel` has them.
    """

    mass: Any
    conduction: Any
    integrals: Array
    cooling: Sequence[Any]
    loads: Array
    outputs: Array
    reach: Array

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
    """Finite elements of a part, whose N temperatures have `places`, shape (3, N) [m].

    `faces`, `tool_point` and `sensors` are as of `Use`; `heat` has the matrices and the tool's motion.
    """

    def __init__(self, solid: Solid, use: Use) -> None:
        import skfem

        self.solid, self.faces = solid, use.faces(solid)
        mesh, element, ratio = solid.mesh, skfem.ElementTetP2(), use.poissons_ratio
        self._basis = basis = skfem.Basis(mesh, element, intorder=2)
        self.places = np.asarray(basis.doflocs)
        facets = [np.unique(np.concatenate([face.facets for face in group])) for group in self.faces]
        base, tip, *groups = (
            fem.mass(skfem.FacetBasis(mesh, element, facets=each, intorder=4)) for each in facets
        )
        loads = np.stack([np.asarray(each.sum(axis=0)).ravel() for each in (base, tip, *groups)], axis=1)
        loads[:, :2] /= loads[:, :2].sum(axis=0)
        centre = self.places @ loads[:, 0]
        self.tool_point, self.sensors = use.places(centre)
        self._rigid = _rigid_motions(self.places, centre)
        self._motion_of_base = _rigid_part(base, self.places, centre)
        motion_of_tip = _rigid_part(tip, self.places, self.tool_point)
        # The heated face's motion, carried to the tool point, is what is not the tool's own.
        wanted = motion_of_tip - (motion_of_tip @ self._rigid.T) @ self._motion_of_base
        self._elastic = Equilibrium(fem.stiffness(basis, 1.0, ratio), basis)
        self._forces = fem.thermal_load(basis, basis, 1.0, ratio)
        motion = self._elastic.solve(wanted) @ self._forces
        stored = fem.mass(skfem.Basis(mesh, element, intorder=4))
        self.heat = Heat(
            mass=stored,
            conduction=fem.conduction(basis),
            integrals=np.asarray(stored.sum(axis=0)).ravel(),
            cooling=groups,
            loads=loads,
            outputs=np.vstack([motion, *(_temperature_at(place, basis) for place in self.sensors)]),
            reach=self.tool_point - centre,
        )

    def displacements(self, rises: Array) -> Array:
        """Displacements [m] relative to the heated face, shape (n, 3, N), by rises, (n, N) [K], and 1 1/K."""
        found = self._elastic.solve((self._forces @ rises.T).T)
        found = found - (found @ self._motion_of_base.T) @ self._rigid
        return found.reshape(len(rises), 3, -1)

    def rises(self) -> Array:
        """Temperatures for a rise of 1 K at each sensor, linear between them along the link, shape (N, 8)."""
        along = self.heat.reach / np.linalg.norm(self.heat.reach)
        places, sensors = along @ self.places, self.sensors @ along
        order = np.argsort(sensors, kind="stable")
        return np.stack(
            [np.interp(places, sensors[order], np.eye(SENSORS)[i, order]) for i in range(SENSORS)], 1
        )

    def linear(self) -> Heat:
        """Matrices for temperatures that are linear in each tetrahedron."""
        return self.heat.onto(_linear_to_quadratic(self._basis))


class Equilibrium:
    """Elastic equilibrium of a body that nothing holds, under forces in balance.

    Conjugate gradients, which need no rigid motion held, in two levels: the preconditioner smooths by the
    sums of the rows, and solves for displacements that are linear in each element, of which six are held (Y.
    Saad, *Iterative Methods for Sparse Linear Systems*, 2nd ed., SIAM 2003, section 13.4). `matrix` is the
    stiffness, shape (3 N, 3 N), all displacements along x first; `basis` the quadratic scalar `skfem.Basis`.
    """

    def __init__(self, matrix: csc_matrix, basis: Any) -> None:
        self._matrix = csr_matrix(matrix)
        corners = basis.mesh.p
        motions = _rigid_motions(corners / np.ptp(corners), corners.mean(axis=1) / np.ptp(corners))
        _, _, order = qr(motions, pivoting=True, mode="economic")
        linear = block_diag([_linear_to_quadratic(basis)] * 3, format="csc")
        self._coarse = csr_matrix(linear[:, np.sort(order[6:])])
        self._factor = fem.symmetric_factor(self._coarse.T @ self._matrix @ self._coarse)
        self._smooth = 1 / np.asarray(abs(self._matrix).sum(axis=1)).ravel()

    def solve(self, forces: Array) -> Array:
        """Displacements under forces in balance, up to a rigid motion, both of shape (m, 3 N).

        For rows that give motions from displacements, and see no rigid ones: the adjoint solutions.
        """
        found = np.empty_like(forces)
        about = LinearOperator(self._matrix.shape, self._approximate)
        for i, force in enumerate(forces):
            found[i], failed = cg(self._matrix, force, rtol=TOLERANCE, maxiter=MOST_ITERATIONS, M=about)
            if failed:
                raise InputError(
                    f"the elastic equations were not solved in {MOST_ITERATIONS} iterations, as with "
                    f"elements that are all but flat; give another {argument('mesh_size')}"
                )
        return found

    def _approximate(self, residual: Array) -> Array:
        found = self._smooth * residual
        found = found + self._coarse @ self._factor.solve(self._coarse.T @ (residual - self._matrix @ found))
        return found + self._smooth * (residual - self._matrix @ found)


def _linear_to_quadratic(basis: Any) -> csr_matrix:
    """Values at corners and middles of edges from those at the corners, shape (N, corners)."""
    corners, middles, ends = basis.nodal_dofs[0], basis.edge_dofs[0], basis.mesh.edges
    rows = np.concatenate([corners, middles, middles])
    columns = np.concatenate([np.arange(len(corners)), *ends])
    weights = np.repeat([1.0, 0.5], [len(corners), 2 * len(middles)])
    return csr_matrix((weights, (rows, columns)), shape=(basis.N, len(corners)))


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
    weighted = (motions.reshape(18, -1) @ weights).reshape(6, -1)
    return np.asarray(np.linalg.solve(motions @ weighted.T, weighted))


def _temperature_at(place: Array, basis: Any) -> Array:
    """Row that gives the temperature at the place in the part that is nearest to a point."""
    _, cell, weights = nearest(place, basis.mesh.p[:, basis.mesh.t])
    dofs, row = basis.element_dofs[:, cell], np.zeros(basis.N)
    row[dofs] = [basis.elem.lbasis(weights[1:], i)[0] for i in range(len(dofs))]
    return row

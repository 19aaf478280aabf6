"""Quasi-static thermo-elasticity: displacement from nodal temperatures.

sigma = 2 mu eps + lambda tr(eps) I - (3 lambda + 2 mu) alpha (T - T_ref) I, div sigma = 0, supports held.

Fully integrated 8-node hexahedra, one through the thickness, lock in bending, so the displacement uses
20-node serendipity elements on the same mesh by default; they contain pure bending exactly. `order=1` gives
the paper's 8-node ones.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bmat, csc_matrix, vstack
from scipy.sparse.linalg import splu

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.paper.fea.library import scikit_fem
from warmlink.orchestration.paper.fea.mesh import Body, Probe, Support, per_element, vertices_at

Integers = NDArray[np.int64]


class ThermoElasticity:
    """Stiffness, thermal load and their factorisation for one body.

    The displacement's component a at scalar unknown n is unknown n + a N, where N is the number of scalar
    unknowns. Each pair of components is a scalar form: a vector-valued one takes far longer to assemble.
    Displacement is trilinear on 8 nodes (`order` 1) or serendipity on 20 (2).
    """

    def __init__(self, body: Body, order: int = 2) -> None:
        skfem = scikit_fem()
        if order not in (1, 2):
            raise InputError(f"order: {order} is neither 1 (8-node) nor 2 (20-node)")
        self.body, self._order = body, order
        element = skfem.ElementHex1() if order == 1 else skfem.ElementHexS2()
        self._basis = skfem.Basis(body.mesh, element, intorder=3 if order == 1 else 5)
        self._heat_basis = self._basis.with_element(skfem.ElementHex1())
        held = np.concatenate([self._held(support) for support in body.supports])
        self._free = np.setdiff1d(np.arange(3 * self._basis.N), held)

    @cached_property
    def elongation_row(self) -> Array:
        """Row that gives the elongation [m] from nodal T - T_ref [K]; it costs one solve, once (adjoint)."""
        wanted = self._mean_x(self.body.target) - self._mean_x(self.body.origin)
        adjoint = np.zeros(3 * self._basis.N)
        adjoint[self._free] = self._factor.solve(wanted[self._free])
        return np.asarray(self.thermal_load.T @ adjoint)

    @cached_property
    def thermal_load(self) -> csc_matrix:
        """Nodal forces [N] from nodal T - T_ref [K]."""
        from skfem import BilinearForm

        first, second = self._lame()
        modulus = (3 * first + 2 * second) * self._property("expansion_coefficient")
        forms = [BilinearForm(lambda t, v, w, a=a: w.modulus * t * v.grad[a]) for a in range(3)]
        return csc_matrix(
            vstack([form.assemble(self._heat_basis, self._basis, modulus=modulus) for form in forms])
        )

    def displacement(self, rise: Array) -> Array:
        """Displacement of the mesh's vertices, shape (3, n) [m], for nodal T - T_ref [K], shape (n,)."""
        solution = np.zeros(3 * self._basis.N)
        solution[self._free] = self._factor.solve((self.thermal_load @ rise)[self._free])
        return np.asarray(solution.reshape(3, -1)[:, self._vertex_unknowns])

    @property
    def _vertex_unknowns(self) -> Integers:
        return np.asarray(self._basis.nodal_dofs[0])

    @cached_property
    def _factor(self) -> Any:
        free = csc_matrix(self._stiffness()[self._free][:, self._free])
        if self._order == 2:
            # With 20-node elements it fills in less, and takes half the time.
            return splu(free, permc_spec="COLAMD")
        return splu(free, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def _stiffness(self) -> csc_matrix:
        """Integral of 2 mu eps(u) : eps(v) + lambda div u div v, by the components of u and v."""
        from skfem import BilinearForm
        from skfem.helpers import dot, grad

        first, second = self._lame()
        blocks: list[list[Any]] = [[None] * 3 for _ in range(3)]
        for a, b in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):

            def form(u: Any, v: Any, w: Any, a: int = a, b: int = b) -> Any:
                strain = w.first * u.grad[b] * v.grad[a] + w.second * u.grad[a] * v.grad[b]
                return strain + w.second * dot(grad(u), grad(v)) if a == b else strain

            blocks[a][b] = BilinearForm(form).assemble(self._basis, first=first, second=second)
            blocks[b][a] = blocks[a][b].T
        return csc_matrix(bmat(blocks))

    def _lame(self) -> tuple[Array, Array]:
        """Lame parameters lambda and mu [Pa] at the quadrature points."""
        modulus, ratio = self._property("youngs_modulus"), self._property("poissons_ratio")
        return modulus * ratio / ((1 + ratio) * (1 - 2 * ratio)), modulus / (2 * (1 + ratio))

    def _property(self, name: str) -> Array:
        return np.broadcast_to(per_element(self.body, name)[:, None], self._basis.dx.shape)

    def _mean_x(self, probe: Probe) -> Array:
        """Weights on all displacement unknowns that give the probe's mean displacement along x [m]."""
        weights = np.zeros(3 * self._basis.N)
        vertices = vertices_at(self.body.mesh, probe.points)
        np.add.at(weights, self._vertex_unknowns[vertices], probe.weights)
        return weights

    def _held(self, support: Support) -> Integers:
        """Unknowns that a support holds."""
        if isinstance(support.where, str):
            scalar = self._basis.get_dofs(self.body.mesh.boundaries[support.where]).all()
        else:
            scalar = self._vertex_unknowns[vertices_at(self.body.mesh, support.where)]
        return np.concatenate([np.asarray(scalar) + axis * self._basis.N for axis in support.axes])

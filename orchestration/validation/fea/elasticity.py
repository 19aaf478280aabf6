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
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from warmlink.fmus.errors import InputError
from warmlink.orchestration.validation.fea.library import scikit_fem
from warmlink.orchestration.validation.fea.mesh import Body, Probe, Support, vertices_at

Array = NDArray[np.float64]


class ThermoElasticity:
    """Stiffness, thermal load and their factorisation for one body.

    Parameters
    ----------
    body : mesh, materials, supports
    order : 1 for 8-node trilinear, 2 for 20-node serendipity displacement
    """

    def __init__(self, body: Body, order: int = 2) -> None:
        skfem = scikit_fem()
        if order not in (1, 2):
            raise InputError(f"order: {order} is neither 1 (8-node) nor 2 (20-node)")
        self.body = body
        element = skfem.ElementVector(skfem.ElementHex1() if order == 1 else skfem.ElementHexS2())
        quadrature = 3 if order == 1 else 5
        self.basis = skfem.Basis(body.mesh, element, intorder=quadrature)
        self._heat_basis = skfem.Basis(body.mesh, skfem.ElementHex1(), intorder=quadrature)
        held = np.concatenate([self._held(support) for support in body.supports])
        self._free = np.setdiff1d(np.arange(self.basis.N), held)

    @cached_property
    def elongation_row(self) -> Array:
        """Row that gives the elongation [m] from nodal T - T_ref [K]; it costs one solve, once (adjoint)."""
        wanted = self._mean_x(self.body.target) - self._mean_x(self.body.origin)
        adjoint = np.zeros(self.basis.N)
        adjoint[self._free] = self._factor.solve(wanted[self._free])
        return np.asarray(self.thermal_load.T @ adjoint)

    @cached_property
    def thermal_load(self) -> csc_matrix:
        """Nodal forces [N] from nodal T - T_ref [K]."""
        from skfem import BilinearForm
        from skfem.helpers import div

        form = BilinearForm(lambda u, v, w: w.modulus * u * div(v))
        first, second = self._lame()
        alpha = self._per_element("expansion_coefficient")
        modulus = (3 * first + 2 * second) * alpha
        return csc_matrix(form.assemble(self._heat_basis, self.basis, modulus=modulus))

    def displacement(self, rise: Array) -> Array:
        """Displacement of the mesh's vertices, shape (3, n) [m], for nodal T - T_ref [K], shape (n,)."""
        solution = np.zeros(self.basis.N)
        solution[self._free] = self._factor.solve((self.thermal_load @ rise)[self._free])
        return np.asarray(solution[self.basis.nodal_dofs])

    @cached_property
    def _factor(self) -> Any:
        from skfem import BilinearForm
        from skfem.helpers import ddot, div, sym_grad

        form = BilinearForm(
            lambda u, v, w: 2 * w.second * ddot(sym_grad(u), sym_grad(v)) + w.first * div(u) * div(v)
        )
        first, second = self._lame()
        stiffness = csc_matrix(form.assemble(self.basis, first=first, second=second))
        free = csc_matrix(stiffness[self._free][:, self._free])
        return splu(free, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def _lame(self) -> tuple[Array, Array]:
        """Lame parameters lambda and mu [Pa] at the quadrature points."""
        modulus, ratio = self._per_element("youngs_modulus"), self._per_element("poissons_ratio")
        return modulus * ratio / ((1 + ratio) * (1 - 2 * ratio)), modulus / (2 * (1 + ratio))

    def _per_element(self, name: str) -> Array:
        values = np.empty(self.body.mesh.nelements)
        for region, cells in self.body.mesh.subdomains.items():
            values[cells] = getattr(self.body.materials[region], name)
        return np.broadcast_to(values[:, None], self.basis.dx.shape)

    def _mean_x(self, probe: Probe) -> Array:
        """Weights on all displacement unknowns that give the probe's mean displacement along x [m]."""
        weights = np.zeros(self.basis.N)
        np.add.at(weights, self.basis.nodal_dofs[0, vertices_at(self.body.mesh, probe.points)], probe.weights)
        return weights

    def _held(self, support: Support) -> NDArray[np.int64]:
        """Unknowns that a support holds."""
        if isinstance(support.where, str):
            names = [f"u^{axis + 1}" for axis in support.axes]
            return np.asarray(self.basis.get_dofs(self.body.mesh.boundaries[support.where]).all(names))
        vertices = vertices_at(self.body.mesh, support.where)
        return np.asarray(self.basis.nodal_dofs[list(support.axes)][:, vertices].ravel())

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
from scipy.sparse import coo_matrix, csc_matrix
from scipy.sparse.linalg import splu

from warmlink.fmus.errors import InputError
from warmlink.orchestration.paper.fea.library import scikit_fem
from warmlink.orchestration.paper.fea.mesh import Body, Probe, Support, vertices_at

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


class ThermoElasticity:
    """Stiffness, thermal load and their factorisation for one body.

    The displacement's component a at scalar unknown n is unknown 3 n + a. Element matrices are products of
    gradient arrays over all elements at once, some ten times faster than a vector-valued form.

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
        element = skfem.ElementHex1() if order == 1 else skfem.ElementHexS2()
        quadrature = 3 if order == 1 else 5
        self._basis = skfem.Basis(body.mesh, element, intorder=quadrature)
        self._heat_basis = skfem.Basis(body.mesh, skfem.ElementHex1(), intorder=quadrature)
        held = np.concatenate([self._held(support) for support in body.supports])
        self._free = np.setdiff1d(np.arange(self.size), held)

    @property
    def size(self) -> int:
        """Number of displacement unknowns, the held ones included."""
        return 3 * int(self._basis.N)

    @cached_property
    def elongation_row(self) -> Array:
        """Row that gives the elongation [m] from nodal T - T_ref [K]; it costs one solve, once (adjoint)."""
        wanted = self._mean_x(self.body.target) - self._mean_x(self.body.origin)
        adjoint = np.zeros(self.size)
        adjoint[self._free] = self._factor.solve(wanted[self._free])
        return np.asarray(self.thermal_load.T @ adjoint)

    @cached_property
    def thermal_load(self) -> csc_matrix:
        """Nodal forces [N] from nodal T - T_ref [K]."""
        first, second = self._lame()
        modulus = (3 * first + 2 * second) * self._per_element("expansion_coefficient")
        shape = np.stack([np.asarray(f[0]) * np.ones(self._basis.dx.shape) for f in self._heat_basis.basis])
        weighted = shape.transpose(1, 2, 0) * (modulus[:, None] * self._basis.dx)[:, :, None]
        columns = self._heat_basis.element_dofs
        size = (self.size, int(self._heat_basis.N))
        return _assembled(self._gradients() @ weighted, self._unknowns(), columns, size)

    def displacement(self, rise: Array) -> Array:
        """Displacement of the mesh's vertices, shape (3, n) [m], for nodal T - T_ref [K], shape (n,)."""
        solution = np.zeros(self.size)
        solution[self._free] = self._factor.solve((self.thermal_load @ rise)[self._free])
        return np.asarray(solution.reshape(-1, 3).T[:, self._vertex_unknowns])

    @property
    def _vertex_unknowns(self) -> Integers:
        return np.asarray(self._basis.nodal_dofs[0])

    @cached_property
    def _factor(self) -> Any:
        stiffness = self._stiffness()
        free = csc_matrix(stiffness[self._free][:, self._free])
        return splu(free, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def _stiffness(self) -> csc_matrix:
        """Integral of 2 mu eps(u) : eps(v) + lambda div u div v."""
        gradients = self._gradients()
        products = (gradients * self._basis.dx[:, None, :]) @ gradients.transpose(0, 2, 1)
        nodes = gradients.shape[1] // 3
        # products[e, i, a, j, b] is the integral of d_a phi_i d_b phi_j.
        products = products.reshape(-1, nodes, 3, nodes, 3)
        first, second = (lame[:, None, None, None, None] for lame in self._lame())
        local = first * products + second * products.transpose(0, 1, 4, 3, 2)
        trace = np.einsum("eicjc->eij", products) * second[:, :, :, 0, 0]
        for axis in range(3):
            local[:, :, axis, :, axis] += trace
        unknowns = self._unknowns()
        return _assembled(local.reshape(-1, 3 * nodes, 3 * nodes), unknowns, unknowns, (self.size, self.size))

    def _gradients(self) -> Array:
        """Gradients of the shape functions, shape (elements, 3 nodes, quadrature points) [1/m]."""
        gradients = np.stack([function[0].grad for function in self._basis.basis])
        nodes, _, elements, points = gradients.shape
        return np.ascontiguousarray(gradients.transpose(2, 0, 1, 3)).reshape(elements, 3 * nodes, points)

    def _unknowns(self) -> Integers:
        """Displacement unknowns of every element, shape (3 nodes, elements)."""
        scalar = self._basis.element_dofs
        return np.asarray((3 * scalar[:, None, :] + np.arange(3)[None, :, None]).reshape(-1, scalar.shape[1]))

    def _lame(self) -> tuple[Array, Array]:
        """Lame parameters lambda and mu [Pa] of every element."""
        modulus, ratio = self._per_element("youngs_modulus"), self._per_element("poissons_ratio")
        return modulus * ratio / ((1 + ratio) * (1 - 2 * ratio)), modulus / (2 * (1 + ratio))

    def _per_element(self, name: str) -> Array:
        values = np.empty(self.body.mesh.nelements)
        for region, cells in self.body.mesh.subdomains.items():
            values[cells] = getattr(self.body.materials[region], name)
        return values

    def _mean_x(self, probe: Probe) -> Array:
        """Weights on all displacement unknowns that give the probe's mean displacement along x [m]."""
        weights = np.zeros(self.size)
        vertices = vertices_at(self.body.mesh, probe.points)
        np.add.at(weights, 3 * self._vertex_unknowns[vertices], probe.weights)
        return weights

    def _held(self, support: Support) -> Integers:
        """Unknowns that a support holds."""
        if isinstance(support.where, str):
            scalar = self._basis.get_dofs(self.body.mesh.boundaries[support.where]).all()
        else:
            scalar = self._vertex_unknowns[vertices_at(self.body.mesh, support.where)]
        return np.concatenate([3 * np.asarray(scalar) + axis for axis in support.axes])


def _assembled(local: Array, rows: Integers, columns: Integers, shape: tuple[int, int]) -> csc_matrix:
    """Sum element matrices (elements, m, n) into the unknowns `rows` (m, elements) and `columns`."""
    row = np.broadcast_to(rows.T[:, :, None], local.shape)
    column = np.broadcast_to(columns.T[:, None, :], local.shape)
    return csc_matrix(coo_matrix((local.ravel(), (row.ravel(), column.ravel())), shape=shape))

"""The heat equation on 8-node trilinear hexahedra, discretised in space.

C dT/dt + (K + h B) T = h b T_a + q Q - r(T), with C the capacity, K the conduction, B and b the cooled
surface, q the heated boundary, r radiation.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, csr_matrix, diags

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.paper.fea.library import scikit_fem
from warmlink.orchestration.paper.fea.mesh import Body, Probe, per_element, vertices_at

STEFAN_BOLTZMANN = 5.670374419e-8  # W/(m2.K4)


@dataclass(frozen=True)
class CooledSurface:
    """Quadrature: `interpolation` (points x nodes), `area` [m2] and `emissivity` at the points."""

    interpolation: csr_matrix
    area: Array
    emissivity: Array

    @cached_property
    def load(self) -> Array:
        """Area belonging to each node [m2]."""
        return np.asarray(self.interpolation.T @ self.area)

    def convective(self, temperature: Array, convection: float, ambient: float) -> float:
        """Heat lost by convection [W]: nodal `temperature`, `ambient` [K], `convection` [W/(m2.K)]."""
        return float(convection * (self.load @ (temperature - ambient)))

    def radiant_load(self, temperature: Array, ambient: float) -> Array:
        """Radiation loss distributed on the nodes [W]: e s (T^4 - T_a^4), a grey body in a black room."""
        at_points = self.interpolation @ temperature
        flux = self.emissivity * STEFAN_BOLTZMANN * (at_points**4 - ambient**4)
        return np.asarray(self.interpolation.T @ (self.area * flux))

    def radiant_matrix(self, temperature: float) -> csr_matrix:
        """Derivative of `radiant_load` at one temperature [K] everywhere, [W/K]."""
        weight = 4 * STEFAN_BOLTZMANN * temperature**3 * self.emissivity * self.area
        return csr_matrix(self.interpolation.T @ diags(weight) @ self.interpolation)


class HeatModel:
    """Matrices of a body's heat equation; `cooled` names the cooled boundaries, None all that it has."""

    def __init__(self, body: Body, cooled: tuple[str, ...] | None = None) -> None:
        skfem = scikit_fem()
        self.body = body
        self._element = skfem.ElementHex1()
        self.basis = skfem.Basis(body.mesh, self._element, intorder=3)
        self._cooled = cooled if cooled is not None else tuple(sorted(_cooled_names(body)))
        unknown = set(self._cooled) - set(body.mesh.boundaries)
        if unknown:
            raise InputError(
                f"cooled: no boundary '{min(unknown)}'; {instead(min(unknown), _cooled_names(body))}"
            )

    @property
    def size(self) -> int:
        """Number of nodes."""
        return int(self.basis.N)

    @cached_property
    def capacity(self) -> csc_matrix:
        """Consistent capacity matrix [J/K]."""
        from skfem import BilinearForm

        form = BilinearForm(lambda u, v, w: w.rho_c * u * v)
        return csc_matrix(form.assemble(self.basis, rho_c=self._property("density", "specific_heat")))

    @cached_property
    def conduction(self) -> csc_matrix:
        """Conduction matrix [W/K]."""
        from skfem import BilinearForm
        from skfem.helpers import dot, grad

        form = BilinearForm(lambda u, v, w: w.k * dot(grad(u), grad(v)))
        return csc_matrix(form.assemble(self.basis, k=self._property("conductivity")))

    @cached_property
    def surface(self) -> CooledSurface:
        """Quadrature of all cooled surfaces."""
        parts = [self._facet_quadrature(name) for name in self._cooled]
        if not parts:
            empty = np.zeros(0)
            return CooledSurface(csr_matrix((0, self.size)), empty, empty)
        emissivity = [
            np.full(len(area), self.body.materials[name.removeprefix("cooled_")].emissivity)
            for name, (_, area) in zip(self._cooled, parts, strict=True)
        ]
        from scipy.sparse import vstack

        interpolation = csr_matrix(vstack([matrix for matrix, _ in parts]))
        return CooledSurface(interpolation, np.concatenate([a for _, a in parts]), np.concatenate(emissivity))

    @cached_property
    def convection(self) -> csc_matrix:
        """Surface matrix for a unit heat transfer coefficient [m2]."""
        s = self.surface
        return csc_matrix(s.interpolation.T @ diags(s.area) @ s.interpolation)

    @cached_property
    def heated_nodes(self) -> NDArray[np.int64]:
        """Nodes on the heated boundary."""
        facets = self.body.mesh.boundaries["heated"]
        return np.asarray(np.unique(self.body.mesh.facets[:, facets]))

    @cached_property
    def heated_load(self) -> Array:
        """How 1 W, spread evenly over the heated boundary, falls on the nodes."""
        interpolation, area = self._facet_quadrature("heated")
        return np.asarray(interpolation.T @ area) / area.sum()

    def probe(self, probe: Probe) -> Array:
        """Row that gives the probe's mean temperature from the nodes'."""
        row = np.zeros(self.size)
        np.add.at(row, vertices_at(self.body.mesh, probe.points), probe.weights)
        return row

    def _facet_quadrature(self, name: str) -> tuple[csr_matrix, Array]:
        facets = scikit_fem().FacetBasis(
            self.body.mesh, self._element, facets=self.body.mesh.boundaries[name], intorder=3
        )
        area = facets.dx
        rows = np.arange(area.size).reshape(area.shape)
        values, row, column = [], [], []
        for i, (shape_function,) in enumerate(facets.basis):
            values.append(np.broadcast_to(np.asarray(shape_function), area.shape).ravel())
            row.append(rows.ravel())
            column.append(np.repeat(facets.element_dofs[i], area.shape[1]))
        entries = (np.concatenate(values), (np.concatenate(row), np.concatenate(column)))
        return csr_matrix(entries, shape=(area.size, self.size)), area.ravel()

    def _property(self, *names: str) -> Any:
        """Product of material properties, constant over each element, at the quadrature points."""
        return np.broadcast_to(per_element(self.body, *names)[:, None], self.basis.dx.shape)


def _cooled_names(body: Body) -> list[str]:
    return [name for name in body.mesh.boundaries if name.startswith("cooled_")]

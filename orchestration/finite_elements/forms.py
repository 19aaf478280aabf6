"""Matrices of heat conduction and thermo-elasticity: integrals over the elements of a mesh.

sigma = 2 mu eps + lambda tr(eps) I - (3 lambda + 2 mu) alpha (T - T_ref) I, div sigma = 0, for an expansion
coefficient alpha and Lame parameters lambda and mu (K.-J. Bathe, *Finite Element Procedures*, 2014).

Properties are numbers, or arrays with one for each element. The displacement's component a at scalar unknown
n is unknown n + a N, where N is the number of scalar unknowns. Each pair of components is a scalar form: a
vector-valued one takes far longer to assemble.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import bmat, csc_matrix, vstack
from scipy.sparse.linalg import splu

from warmlink.fmus.errors import MissingExtraError


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
    """Integral of 2 mu eps(u) : eps(v) + lambda div u div v, from Young's modulus and Poisson's ratio."""
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
    """Assemble a form with properties that are constant over each element."""
    shape = bases[0].dx.shape
    at_points = {
        name: np.broadcast_to(np.asarray(value)[..., None], shape) for name, value in properties.items()
    }
    return csc_matrix(scikit_fem().BilinearForm(form).assemble(*bases, **at_points))

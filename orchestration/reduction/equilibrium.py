"""Elastic equilibrium of a free body under forces in balance: conjugate gradients in two levels."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import qr
from scipy.sparse import block_diag, csc_matrix, csr_matrix, diags
from scipy.sparse.linalg import LinearOperator, cg, eigsh, splu

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array

SYMMETRIC: dict[str, Any] = {
    "permc_spec": "MMD_AT_PLUS_A",
    "diag_pivot_thresh": 0.0,
    "options": {"SymmetricMode": True},
}
"""How SuperLU is told that a matrix is symmetric and definite."""

TOLERANCE = 1e-9
MOST_ITERATIONS = 400
SMOOTHED = 10.0
"""Ratio of the largest eigenvalue to the least that the smoother deals with."""


class Equilibrium:
    """Stiffness of a body that nothing holds.

    Forces in balance do no work in a rigid motion, so that six unknowns may be held without a reaction. The
    preconditioner smooths by Chebyshev's polynomial of degree 3 and solves exactly for displacements that
    are linear in each element (Y. Saad, *Iterative Methods for Sparse Linear Systems*, 2nd ed., SIAM 2003,
    sections 12.3 and 13.4).

    Parameters
    ----------
    stiffness : shape (3 N, 3 N), displacements along x first, then y and z
    rigid : the six rigid motions, shape (6, 3 N)
    basis : quadratic scalar `skfem.Basis` with N unknowns
    """

    def __init__(self, stiffness: csr_matrix, rigid: Array, basis: Any) -> None:
        size, corners = basis.N, np.asarray(basis.nodal_dofs[0])
        candidates = np.concatenate([corners + axis * size for axis in range(3)])
        scale = np.abs(rigid).max(axis=1)[:, None]
        _, _, order = qr(rigid[:, candidates] / scale, pivoting=True, mode="economic")
        self._free = np.setdiff1d(np.arange(3 * size), candidates[order[:6]])
        self._matrix = csr_matrix(stiffness[self._free][:, self._free])
        self._coarse = csr_matrix(block_diag([linear_to_quadratic(basis)] * 3))[self._free]
        kept = np.flatnonzero(np.isin(candidates, self._free))
        self._coarse = csr_matrix(self._coarse[:, kept])
        self._factor = splu(csc_matrix(self._coarse.T @ self._matrix @ self._coarse), **SYMMETRIC)
        self._inverse = 1 / self._matrix.diagonal()
        root = diags(np.sqrt(self._inverse))
        largest = eigsh(root @ self._matrix @ root, k=1, tol=0.01, return_eigenvectors=False)
        self._largest = 1.05 * float(largest[0])

    def solve(self, forces: Array) -> Array:
        """Displacements under forces in balance, six of them held at 0, shape (m, 3 N).

        With rows that give motions from displacements, and do not see rigid ones, in place of the forces:
        the adjoint solutions, whose work with any forces in balance is the motion.

        Parameters
        ----------
        forces : shape (m, 3 N)
        """
        found = np.zeros_like(forces)
        preconditioner = LinearOperator(self._matrix.shape, self._approximate)
        for row, target in zip(found, forces, strict=True):
            row[self._free], failed = cg(
                self._matrix,
                target[self._free],
                rtol=TOLERANCE,
                maxiter=MOST_ITERATIONS,
                M=preconditioner,
            )
            if failed:
                raise InputError(
                    f"the elastic equations were not solved in {MOST_ITERATIONS} iterations, as with "
                    "elements that are all but flat; give another --mesh-size"
                )
        return found

    def _approximate(self, residual: Array) -> Array:
        found = self._smooth(residual)
        found = found + self._coarse @ self._factor.solve(self._coarse.T @ (residual - self._matrix @ found))
        return found + self._smooth(residual - self._matrix @ found)

    def _smooth(self, residual: Array) -> Array:
        """Solve approximately, for the upper part of the spectrum."""
        centre, half = self._largest * (1 + 1 / SMOOTHED) / 2, self._largest * (1 - 1 / SMOOTHED) / 2
        direction = self._inverse * residual / centre
        found, ratio = direction, half / centre
        for _ in range(2):
            residual = residual - self._matrix @ direction
            following = 1 / (2 * centre / half - ratio)
            direction = following * (ratio * direction + 2 / half * self._inverse * residual)
            found, ratio = found + direction, following
        return found


def linear_to_quadratic(basis: Any) -> csr_matrix:
    """Values at corners and middles of edges from those at the corners, shape (N, corners)."""
    corners, middles, ends = basis.nodal_dofs[0], basis.edge_dofs[0], basis.mesh.edges
    count = len(corners)
    rows = np.concatenate([corners, middles, middles])
    columns = np.concatenate([np.arange(count), ends[0], ends[1]])
    weights = np.concatenate([np.ones(count), np.full(2 * len(middles), 0.5)])
    return csr_matrix((weights, (rows, columns)), shape=(basis.N, count))

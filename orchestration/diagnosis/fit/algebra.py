"""Linear algebra of columns of very different size."""

from __future__ import annotations

import numpy as np

from warmlink.orchestration.arrays import Array


def correlation_of(gram: Array) -> tuple[Array, Array]:
    """A Gram matrix with every column at unit length, shape (n, n), and the lengths, shape (n,)."""
    length = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    return gram / np.outer(length, length), length


def inverse_of(gram: Array, least: float) -> Array:
    """Pseudo-inverse of a Gram matrix, without directions below a share of the largest, shape (n, n)."""
    correlation, length = correlation_of(gram)
    return np.asarray(np.linalg.pinv(correlation, rcond=least, hermitian=True) / np.outer(length, length))


def root_of(covariance: Array) -> Array:
    """Matrix R with R R' = covariance, shape (n, n)."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def orthonormal(columns: Array, least: float = 1e-7) -> Array:
    """Orthonormal basis of the columns' span, shape (rows, rank), without what adds less than a share."""
    from scipy.linalg import orth

    size = np.linalg.norm(columns, axis=0)
    scaled = columns[:, size > 0] / size[size > 0]
    return np.asarray(orth(scaled, rcond=least)) if scaled.size else np.zeros((len(columns), 0))

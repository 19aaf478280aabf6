"""Linear algebra of columns of very different size."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


def correlation_of(gram: Vector) -> tuple[Vector, Vector]:
    """A Gram matrix with every column at unit length, shape (n, n), and the lengths, shape (n,)."""
    length = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    return gram / np.outer(length, length), length


def inverse_of(gram: Vector, least: float) -> Vector:
    """Pseudo-inverse of a Gram matrix, without directions below a share of the largest, shape (n, n)."""
    correlation, length = correlation_of(gram)
    return np.asarray(np.linalg.pinv(correlation, rcond=least, hermitian=True) / np.outer(length, length))


def root_of(covariance: Vector) -> Vector:
    """Matrix R with R R' = covariance, shape (n, n)."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def orthonormal(columns: Vector, least: float = 1e-7) -> Vector:
    """Orthonormal basis of the columns' span, shape (rows, rank), without what adds less than a share."""
    size = np.linalg.norm(columns, axis=0)
    kept = columns[:, size > 1e-12 * max(float(size.max(initial=0.0)), 1e-300)]
    if kept.shape[1] == 0:
        return np.zeros((columns.shape[0], 0))
    left, singular, _ = np.linalg.svd(kept / np.linalg.norm(kept, axis=0), full_matrices=False)
    return left[:, singular > least * singular[0]]

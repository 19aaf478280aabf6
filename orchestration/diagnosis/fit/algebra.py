"""Linear algebra of columns of very different size."""

from __future__ import annotations

import numpy as np

from warmlink.orchestration.arrays import Array

_NOTHING = 1e-9
"""Change of all residuals together, in standard deviations, that is one of rounding alone."""


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


def bounded_step(gram: Array, gradient: Array, lower: Array, upper: Array) -> tuple[Array, float]:
    """Step that minimises the linearised chi-square between bounds, and the decrease it promises."""
    correlation, scale = correlation_of(gram)
    # What changes nothing over its whole range, even if unbounded, stays where it is.
    alive = np.sqrt(np.diag(gram)) * np.minimum(upper - lower, 1e150) > _NOTHING
    matrix = correlation + 1e-11 * np.eye(scale.size)
    matrix[~alive, :] = 0.0
    matrix[:, ~alive] = 0.0
    matrix[~alive, ~alive] = 1.0
    target = np.where(alive, gradient / scale, 0.0)
    step = np.linalg.solve(matrix, target)
    low, high = lower * scale, upper * scale
    if np.any(step < low) or np.any(step > high):
        from scipy.optimize import lsq_linear

        factor = np.linalg.cholesky(matrix + 1e-12 * np.eye(target.size))
        room = low, np.where(high > low, high, low + 1e-12)
        step = lsq_linear(factor.T, np.linalg.solve(factor, target), room, method="bvls").x.clip(low, high)
    decrease = float(2 * target @ step - step @ correlation @ step)
    return step / scale, decrease

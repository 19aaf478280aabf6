"""Small matrices in the arithmetic that serves floats and CasADi expressions alike.

Components have only vectors, so matrices are passed as flat vectors: row after row, and a symmetric matrix by
the rows of its upper triangle.
"""

from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component.arithmetic import Number, alike, maximum, minimum, symbolic, total, where

PIVOT_ROUNDING = 1e-9
"""Share of a diagonal element below which a pivot counts as none."""


def packed_size(size: int) -> int:
    """Elements of the upper triangle of a square matrix."""
    return size * (size + 1) // 2


def matrix(flat: Number, rows: int) -> Number:
    """Matrix of so many rows from its elements, row after row."""
    return _elements(flat, np.arange(flat.shape[0]).reshape(rows, -1))


def symmetric(packed: Number, size: int) -> Number:
    """Symmetric matrix from the rows of its upper triangle."""
    return _elements(packed, _places(size))


def upper(square: Number) -> Number:
    """Rows of a square matrix's upper triangle, in one vector."""
    rows, columns = _triangle(square.shape[0])
    return square[_listed(rows + columns * square.shape[0])] if symbolic(square) else square[rows, columns]


def _elements(vector: Number, places: NDArray[np.intp]) -> Number:
    """Matrix of a vector's elements at places."""
    if symbolic(vector):
        import casadi

        return casadi.reshape(vector[_listed(places.T.ravel())], *places.shape)
    return vector[places]


def _listed(places: NDArray[np.intp]) -> list[int]:
    return [int(place) for place in places]


@lru_cache
def _triangle(size: int) -> tuple[NDArray[np.intp], ...]:
    return np.triu_indices(size)


def upper_diagonal(packed: Number, size: int) -> Number:
    """Diagonal of a symmetric matrix from the rows of its upper triangle."""
    return packed[_listed(np.diagonal(_places(size)))]


diagonal = partial(alike, "diag")
"""Square matrix with a vector on its diagonal, or the diagonal of a square matrix."""

dot = partial(alike, "dot")
"""Scalar product of two vectors."""


def outer(a: Number, b: Number) -> Number:
    """Product of a column and a row."""
    if symbolic(a, b):
        import casadi

        return casadi.mtimes(a, casadi.transpose(b))
    return np.outer(a, b)


def blocks(upper_left: Number, upper_right: Number, lower_right: Number) -> Number:
    """Block upper triangular matrix."""
    if symbolic(upper_left, upper_right, lower_right):
        import casadi

        empty = casadi.DM(lower_right.shape[0], upper_left.shape[1])
        return casadi.vertcat(casadi.horzcat(upper_left, upper_right), casadi.horzcat(empty, lower_right))
    zero = np.zeros((lower_right.shape[0], upper_left.shape[1]))
    return np.block([[upper_left, upper_right], [zero, lower_right]])


def least_pivot(square: Number) -> Number:
    """Least pivot of a symmetric matrix's elimination, each relative to its diagonal element.

    It is above 0 for a positive definite matrix, 0 but for rounding for one that lacks rank, and below 0 for
    one that is no covariance at all.
    """
    size = square.shape[0]
    least: Number = 1.0
    rest, floor = square, PIVOT_ROUNDING * maximum(total(diagonal(square)), PIVOT_ROUNDING)
    for i in range(size):
        scale = maximum(square[i, i], floor)
        least = minimum(least, rest[i, i] / scale)
        inverse = where(rest[i, i] > PIVOT_ROUNDING * scale, 1.0 / maximum(rest[i, i], floor), 0.0)
        rest = rest - outer(inverse * rest[:, i], rest[:, i])
    return least


@lru_cache
def _places(size: int) -> NDArray[np.intp]:
    """Where each element of a symmetric matrix lies in its upper triangle's rows."""
    places = np.zeros((size, size), dtype=np.intp)
    places[np.triu_indices(size)] = np.arange(packed_size(size))
    return places + np.triu(places, 1).T

"""Matrices in flat vectors: the same in floats and in CasADi's expressions."""

from typing import Any

import casadi as ca
import numpy as np
import pytest

from warmlink.controllers import matrices as m

DRAW = np.random.default_rng(3)


def test_a_symmetric_matrix_survives_packing() -> None:
    square = DRAW.normal(size=(5, 5))
    square = square + square.T
    assert np.array_equal(m.symmetric(m.upper(square), 5), square)
    assert m.upper(square).size == m.packed_size(5) == 15


@pytest.mark.parametrize("size", [2, 5])
def test_both_arithmetics_agree(size: int) -> None:
    a, b, flat = DRAW.normal(size=size), DRAW.normal(size=size), DRAW.normal(size=2 * size)
    packed = DRAW.normal(size=m.packed_size(size))

    def all_of(a: Any, b: Any, flat: Any, packed: Any) -> list[Any]:
        square = m.symmetric(packed, size)
        stacked = m.blocks(square, m.outer(a, b), m.diagonal(b))
        return [
            m.dot(a, b),
            m.outer(a, b),
            square @ a,
            m.matrix(flat, 2) @ a,
            m.upper(square @ m.diagonal(b)),
            m.diagonal(square),
            stacked,
        ]

    symbols = [ca.SX.sym("v", each.size) for each in (a, b, flat, packed)]
    found = ca.Function("f", symbols, all_of(*symbols))(a, b, flat, packed)
    for symbolic, plain in zip(found, all_of(a, b, flat, packed), strict=True):
        assert np.squeeze(np.array(symbolic)) == pytest.approx(np.squeeze(plain), rel=1e-14)


@pytest.mark.parametrize(("change", "definite"), [(0.0, True), (-1.0, False), (3.0, False)])
def test_the_least_pivot_tells_a_covariance_in_both_arithmetics(change: float, definite: bool) -> None:
    square = np.array([[2.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 1.0]])
    square[2, 2] += change if change < 0 else 0.0
    square[0, 1] = square[1, 0] = 1.0 + max(change, 0.0)
    least = m.least_pivot(square)
    assert (least > 0) == definite
    entries = ca.SX.sym("entries", 6)
    symbolic = ca.Function("f", [entries], [m.least_pivot(m.symmetric(entries, 3))])
    assert float(symbolic(m.upper(square))) == pytest.approx(least, rel=1e-12)

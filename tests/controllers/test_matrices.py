"""Matrices in flat vectors: the same in floats and in CasADi's expressions."""

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

    def all_of(a: object, b: object, flat: object, packed: object) -> list[object]:
        square = m.symmetric(packed, size)
        stacked = m.blocks(square, m.outer(a, b), m.diagonal(b))
        return [
            m.dot(a, b),
            m.outer(a, b),
            m.product(square, a),
            m.product(m.matrix(flat, 2), a),
            m.upper(m.product(square, m.diagonal(b))),
            m.diagonal_of(square),
            stacked,
        ]

    symbols = [ca.SX.sym("v", each.size) for each in (a, b, flat, packed)]
    found = ca.Function("f", symbols, all_of(*symbols))(a, b, flat, packed)
    for symbolic, plain in zip(found, all_of(a, b, flat, packed), strict=True):
        assert np.squeeze(np.array(symbolic)) == pytest.approx(np.squeeze(plain), rel=1e-14)

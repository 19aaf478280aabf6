"""Elimination written out on expressions, against NumPy."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warmlink.fmus.packaging.native.micro_step import elimination_order, solver


def test_a_chain_is_worked_from_both_ends_without_fill() -> None:
    chain = [{i - 1, i, i + 1} & set(range(7)) for i in range(7)]
    assert elimination_order(chain) == [0, 6, 1, 5, 2, 4, 3]
    size = 7
    pattern = np.eye(size) * 4 + np.eye(size, k=1) + np.eye(size, k=-1)
    matrix = casadi.SX.sym("a", casadi.sparsify(casadi.DM(pattern)).sparsity())
    right = casadi.SX.sym("b", size)
    solve = casadi.Function("solve", [matrix, right], [casadi.cse(solver(matrix)(right))])
    # 3n - 2 reads of the matrix, n of the right side, n results, and 8 operations an unknown at most.
    assert solve.n_instructions() < (3 + 1 + 1 + 8) * size


def test_an_arrow_keeps_its_tip_for_last() -> None:
    arrow = [{0, i} for i in range(6)]
    arrow[0] = set(range(6))
    assert set(elimination_order(arrow)[-2:]) >= {0}


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 9), st.integers(0, 2**32 - 1), st.floats(0.0, 1.0))
def test_solutions_are_those_of_numpy(size: int, seed: int, density: float) -> None:
    random = np.random.default_rng(seed)
    values = np.where(random.random((size, size)) < density, random.normal(size=(size, size)), 0.0)
    # Diagonally dominant, as I - gamma h J of a dissipative system is.
    np.fill_diagonal(values, 1.0 + np.abs(values).sum(axis=1))
    matrix = casadi.SX.sym("a", casadi.sparsify(casadi.DM(values)).sparsity())
    rights = casadi.SX.sym("b", size, 2)
    solve = solver(matrix)
    solved = casadi.horzcat(*(solve(rights[:, i]) for i in range(2)))
    given_rights = random.normal(size=(size, 2))
    sparse = casadi.DM(matrix.sparsity(), values[*np.array(matrix.sparsity().get_triplet())])
    found = casadi.Function("solve", [matrix, rights], [solved])(sparse, given_rights)
    assert np.asarray(found) == pytest.approx(np.linalg.solve(values, given_rights), rel=1e-10, abs=1e-12)

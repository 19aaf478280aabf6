"""The random generator: exact in doubles, alike in NumPy and CasADi, and random enough."""

import math

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from warmlink.fmus import noise

A, B = (2147483563, 40014), (2147483399, 40692)

halves = st.tuples(st.integers(1, A[0] - 1), st.integers(1, B[0] - 1))


@given(state=halves)
def test_doubles_carry_the_generator_exactly(state: tuple[int, int]) -> None:
    """Against whole numbers of any length; P. L'Ecuyer, CACM 31 (1988) 742, figure 3."""
    a, b = state
    x = np.array(state, dtype=float)
    for _ in range(20):
        a, b = a * A[1] % A[0], b * B[1] % B[0]
        x = noise.advanced(*x)
        assert x == (a, b)
        z = a - b
        assert noise.uniform(*x) == (z + A[0] - 1 if z < 1 else z) / A[0]


def test_no_state_gives_the_zero_whose_logarithm_has_no_end() -> None:
    assert noise.uniform(7.0, 7.0) == (A[0] - 1) / A[0]
    assert noise.uniform(8.0, 7.0) == 1 / A[0]
    assert noise.uniform(7.0, 8.0) == (A[0] - 2) / A[0]


@given(seed=st.integers(0, 2**31 - 1), channel=st.integers(0, 2000))
def test_every_seed_starts_within_the_generators_range(seed: int, channel: int) -> None:
    (a,), (b,) = noise.starts(float(seed), (channel,))
    assert 1 <= a < A[0]
    assert 1 <= b < B[0]
    assert a == round(a)
    assert b == round(b)


def test_casadi_draws_the_very_same_numbers() -> None:
    a, b, seed = casadi.SX.sym("a", 8), casadi.SX.sym("b", 8), casadi.SX.sym("seed")
    draw = casadi.Function("draw", [a, b], list(noise.normals(a, b)))
    start = casadi.Function("start", [seed], list(noise.starts(seed, range(8))))
    here = noise.starts(17.0, range(8))
    there = start(17.0)
    for _ in range(2000):
        mine, *here = noise.normals(*here)
        theirs, *there = draw(*there)
        assert np.array_equal(here[0], there[0].full().ravel())
        assert np.array_equal(here[1], there[1].full().ravel())
        # The logarithm and the cosine may round otherwise.
        assert theirs.full().ravel() == pytest.approx(mine, rel=1e-13, abs=1e-15)


def drawn(a: np.ndarray, b: np.ndarray, count: int) -> np.ndarray:
    rows = []
    for _ in range(count):
        row, a, b = noise.normals(a, b)
        rows.append(row)
    return np.array(rows)


def test_one_generator_draws_normal_and_white_numbers() -> None:
    numbers = drawn(*noise.starts(3.0, range(8)), 20000)
    for channel in numbers.T:
        assert stats.kstest(channel, "norm").pvalue > 1e-3
        for lag in (1, 2, 3, 30):
            assert abs(np.corrcoef(channel[:-lag], channel[lag:])[0, 1]) < 4 / math.sqrt(20000)
    between = np.corrcoef(numbers.T) - np.eye(8)
    assert np.abs(between).max() < 4 / math.sqrt(20000)


def test_neighbouring_seeds_have_nothing_to_do_with_each_other() -> None:
    seeds = [noise.starts(float(seed), (0,)) for seed in range(400)]
    numbers = drawn(*np.array(seeds)[:, :, 0].T, 400)
    # Over the seeds at each moment, and from each seed to the next over time.
    p = np.array([stats.kstest(row, "norm").pvalue for row in numbers])
    assert stats.kstest(p, "uniform").pvalue > 1e-3
    apart = numbers[:, 1:] - numbers[:, :-1]
    assert apart.var() == pytest.approx(2, abs=0.05)
    next_to = np.array([np.corrcoef(numbers[:, i], numbers[:, i + 1])[0, 1] for i in range(399)])
    assert np.abs(next_to).max() < 5 / math.sqrt(400)
    firsts = [noise.uniform(*noise.starts(float(s), (0,)))[0] for s in range(51)]
    steps = np.diff(firsts).tolist()
    assert len({round(step % 1.0, 6) for step in steps}) == 50


def test_a_seed_repeats_its_numbers() -> None:
    first = drawn(*noise.starts(5.0, range(2)), 10)
    assert np.array_equal(first, drawn(*noise.starts(5.0, range(2)), 10))
    assert not np.any(first == drawn(*noise.starts(6.0, range(2)), 10))
    single, *state = noise.normals(*noise.starts(5.0, (1,)))
    assert single == first[0, 1]
    assert noise.normals(*state)[0] == first[1, 1]

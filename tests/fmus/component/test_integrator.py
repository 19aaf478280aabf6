"""The Rosenbrock step: its order, its damping, and the Jacobian it uses."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warmlink.fmus.component.integrator import ComplexStepJacobian, ros2, solution_of


def rosenbrock_step(
    rates: Callable[[np.ndarray, float], np.ndarray],
    jacobian: np.ndarray,
    x: np.ndarray,
    time: float,
    step: float,
) -> np.ndarray:
    """State after one step."""
    solve = solution_of(jacobian, step)
    return ros2(rates(x, time), solve, lambda ahead: rates(ahead, time + step), x, step)


def march(step: float, jacobian_factor: float) -> float:
    """Error at 1 s of x' = -x^2 + cos t, with the Jacobian off by a factor."""

    def rates(x: np.ndarray, time: float) -> np.ndarray:
        return -(x**2) + math.cos(time)

    x, count = np.array([0.5]), round(1 / step)
    for k in range(count):
        x = rosenbrock_step(rates, np.array([[-2 * x[0] * jacobian_factor]]), x, k * step, step)
    return float(x[0])


@pytest.mark.parametrize("factor", [1.0, 0.5, 0.0, 2.0])
def test_second_order_whatever_matrix_stands_in_for_the_jacobian(factor: float) -> None:
    exact = march(1 / 4096, 1.0)
    errors = [abs(march(1 / n, factor) - exact) for n in (16, 32, 64, 128)]
    assert math.log2(errors[0] / errors[-1]) / 3 == pytest.approx(2, abs=0.15)


@settings(deadline=None)
@given(exponent=st.floats(0, 15))
def test_what_is_stiff_is_damped_within_a_step(exponent: float) -> None:
    """R(z) stays below 1 and goes to 0 as z goes to minus infinity: L-stable."""
    stiffness = 10.0**exponent
    after = rosenbrock_step(lambda x, t: -stiffness * x, np.array([[-stiffness]]), np.array([1.0]), 0.0, 1.0)
    gamma = 1 - 1 / math.sqrt(2)
    z = -stiffness
    exact = (1 + (1 - 2 * gamma) * z) / (1 - gamma * z) ** 2
    assert after[0] == pytest.approx(exact, rel=1e-6, abs=1e-14)
    assert abs(after[0]) < 1
    assert abs(after[0]) < 10 / stiffness


def test_a_stiff_mode_does_not_disturb_a_slow_one() -> None:
    matrix = np.array([[-1e12, 1e12], [0.0, -1.0]])
    x = np.array([5.0, 1.0])
    for k in range(100):
        x = rosenbrock_step(lambda z, t: matrix @ z, matrix, x, k * 0.01, 0.01)
    assert x[1] == pytest.approx(math.exp(-1), rel=1e-5)
    assert x[0] == pytest.approx(x[1], rel=1e-5)


@given(seed=st.integers(0, 10**6), size=st.integers(1, 12))
def test_the_complex_step_finds_any_jacobian(seed: int, size: int) -> None:
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(size, size)) * (rng.random((size, size)) < 0.4)

    def rates(x: np.ndarray) -> np.ndarray:
        return matrix @ (x * x)

    x = rng.normal(size=size)
    exact = matrix * 2 * x
    found = ComplexStepJacobian(matrix != 0)(rates, x)
    assert found == pytest.approx(exact, rel=1e-13, abs=1e-15)


def test_a_chain_takes_three_evaluations() -> None:
    size, calls = 40, 0
    structure = np.abs(np.subtract.outer(np.arange(size), np.arange(size))) <= 1

    def rates(x: np.ndarray) -> np.ndarray:
        nonlocal calls
        calls += 1
        return structure @ x

    assert np.array_equal(ComplexStepJacobian(structure)(rates, np.ones(size)), structure.astype(float))
    assert calls == 3

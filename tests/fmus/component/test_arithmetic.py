"""One arithmetic: the same values for floats, complex numbers, arrays and CasADi, and the same slopes."""

import math
from collections.abc import Callable

import casadi
import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from warmlink.fmus.component import arithmetic as ar

STEP = 1e-30

numbers = st.floats(-50, 50, allow_nan=False)

ONE: dict[str, Callable] = {
    "absolute": ar.absolute,
    "exp": ar.exp,
    "sin": ar.sin,
    "cos": ar.cos,
    "erf": ar.erf,
    "log": lambda x: ar.log(ar.absolute(x) + 1e-3),
    "sqrt": lambda x: ar.sqrt(x * x + 1e-3),
    "clip": lambda x: ar.clip(x, -7.3, 11.9),
    "floor": lambda x: ar.floor(x) * 1.0,
    "where": lambda x: ar.where(ar.real(x) > 3.3, x * x, 2 * x),
}
TWO: dict[str, Callable] = {"minimum": ar.minimum, "maximum": ar.maximum}


def in_casadi(function: Callable, *values: float) -> tuple[float, list[float]]:
    """Value and slopes of a function written in CasADi."""
    symbols = [casadi.SX.sym(f"x{i}") for i in range(len(values))]
    value = function(*symbols)
    slopes = [casadi.jacobian(value, symbol) for symbol in symbols]
    found = casadi.Function("f", symbols, [value, *slopes])(*values)
    return float(found[0]), [float(each) for each in found[1:]]


def check(function: Callable, *values: float) -> None:
    plain = float(function(*values))
    assert float(function(*(np.array([v, v]) for v in values))[1]) == plain
    symbolic, slopes = in_casadi(function, *values)
    assert symbolic == pytest.approx(plain, rel=1e-13, abs=1e-300)
    for i, slope in enumerate(slopes):
        stepped = [complex(v, STEP if i == j else 0.0) for j, v in enumerate(values)]
        result = complex(function(*stepped))
        # The real part is right to second order in the step: log(1 + ih) is h^2 / 2 + ih.
        assert result.real == pytest.approx(plain, rel=1e-13, abs=STEP**2)
        # Below 1e-280 the step itself leaves the range of normal doubles.
        assert result.imag / STEP == pytest.approx(slope, rel=1e-12, abs=1e-280)
        as_array = function(*(np.array([v]) for v in stepped))
        assert complex(as_array[0]) == pytest.approx(result, rel=1e-13)


@pytest.mark.parametrize("name", ONE)
@given(x=numbers)
@example(x=0.999)
def test_functions_of_one_number(name: str, x: float) -> None:
    # At a corner the slope is either side's.
    assume(all(abs(x - corner) > 1e-9 for corner in (0.0, -7.3, 11.9, 3.3)))
    check(ONE[name], x)


@pytest.mark.parametrize("name", TWO)
@given(x=numbers, y=numbers)
def test_functions_of_two_numbers(name: str, x: float, y: float) -> None:
    assume(x != y)
    check(TWO[name], x, y)


@given(x=st.floats(-4, 4))
def test_the_error_function_is_that_of_the_c_library(x: float) -> None:
    assert ar.erf(x) == math.erf(x)
    assert in_casadi(ar.erf, x)[1][0] == pytest.approx(2 / math.sqrt(math.pi) * math.exp(-x * x), rel=1e-12)


def test_where_keeps_nan_out_of_the_branch_not_taken() -> None:
    x = casadi.SX.sym("x", 3)
    chosen = casadi.Function("f", [x], [ar.where(x > 0, x, math.nan), ar.where(x > 0, 1.0, x)])
    first, second = (each.full().ravel() for each in chosen([1.0, -1.0, 2.0]))
    assert np.array_equal(first, [1.0, math.nan, 2.0], equal_nan=True)
    assert second.tolist() == [1.0, -1.0, 1.0]
    vector = np.array([1.0, -1.0, 2.0])
    assert np.array_equal(ar.where(vector > 0, vector, math.nan), first, equal_nan=True)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1.0, -1e12])
def test_finite(value: float) -> None:
    assert bool(ar.finite(value)) == math.isfinite(value)
    x = casadi.SX.sym("x")
    assert bool(casadi.Function("f", [x], [ar.finite(x)])(value)) == math.isfinite(value)


def test_vectors_are_built_alike() -> None:
    x = casadi.SX.sym("x", 2)
    parts = casadi.Function("f", [x], [ar.stack(1.0, x, x[0]), ar.placed(x[1], 2, 4), ar.total(x)])(
        [3.0, 5.0]
    )
    v = np.array([3.0, 5.0])
    assert parts[0].full().ravel().tolist() == ar.stack(1.0, v, v[0]).tolist() == [1, 3, 5, 3]
    assert parts[1].full().ravel().tolist() == ar.placed(v[1], 2, 4).tolist() == [0, 0, 5, 0]
    assert float(parts[2]) == ar.total(v) == 8
    assert ar.placed(1j, 0, 2).tolist() == [1j, 0]

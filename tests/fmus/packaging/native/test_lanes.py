"""CasADi's C in vectors: every lane computes what the plain function computes."""

import ctypes
import re

import casadi
import numpy as np
import pytest

from tests.built import call_of
from warmlink.fmus.component.join import join
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.packaging.native.c_code import functions_text
from warmlink.fmus.packaging.native.casadi_code import function
from warmlink.fmus.packaging.native.compile import compilers, platforms_named
from warmlink.fmus.packaging.native.rollout import aligned
from warmlink.fmus.packaging.native.rollout_code import compiled

LANES = 4
CALL = "void call(const lanes *given, lanes *found) { all_of(given, found); }"


def everything(kind: type, a: casadi.SX, b: casadi.SX) -> list[casadi.SX]:
    """What components use: arithmetic, choices, comparisons, and functions of one number and of two."""
    whole = casadi.floor(a) + casadi.ceil(b)
    chosen = casadi.if_else(casadi.logic_and(a > 0, b <= 1), a * b, a - b)
    told = casadi.logic_or(a == b, casadi.logic_not(a < b)) + (a != b)
    one = [
        getattr(casadi, name)(a)
        for name in ("fabs", "sqrt", "exp", "log", "sin", "cos", "erf", "tanh", "sign")
    ]
    two = [casadi.atan2(a, b), casadi.fmin(a, b), casadi.fmax(a, b), casadi.power(a, b), casadi.fmod(a, b)]
    constants = [kind(float("inf")), kind(3.5), casadi.if_else(a > 1e300, kind(float("nan")), 2.0)]
    return [whole, chosen, told, *one, *two, *constants, a / b, a * a]


@pytest.mark.parametrize("kind", [casadi.SX, casadi.MX])
def test_each_lane_computes_what_one_number_would(kind: type) -> None:
    given = kind.sym("given", 2)
    found = everything(kind, given[0], given[1])
    vectors = [
        casadi.mtimes(kind.ones(3, 2) * given[0], given),
        casadi.if_else(given > 0.5, given, kind.zeros(2)),
    ]
    whole = function("all", [given], casadi.vertcat(*found, *vectors))
    assert re.search(r"\(a\d+\?a\d+:a\d+\)", functions_text([whole], ())), "a choice is one expression"
    call = call_of(functions_text([whole], (), LANES) + CALL)
    rng = np.random.default_rng(2)
    pairs = [rng.uniform(-3, 3, (2, LANES)) for _ in range(200)]
    pairs += [rng.uniform(0, 1, (2, LANES)) ** 9 for _ in range(50)]
    pairs += [np.array([[0.0, np.inf, np.nan, 1e9], [-0.0, 1.0, 2.0, -7e8]])]
    inside, outside = (aligned(np.zeros((rows, LANES))) for rows in (2, whole.size1_out(0)))
    for pair in pairs:
        inside[:] = pair
        call(*(ctypes.c_void_p(each.ctypes.data) for each in (inside, outside)))
        expected = np.column_stack([np.array(whole(column)).ravel() for column in pair.T])
        np.testing.assert_allclose(outside, expected, rtol=4e-15, atol=4e-16)


def test_an_operation_that_has_no_c_is_named() -> None:
    given = casadi.SX.sym("given")
    whole = function("rare", [given], casadi.erfinv(given))
    with pytest.raises(InputError, match="rare: CasADi's operation erfinv has no C here"):
        functions_text([whole], ())


def test_a_system_whose_parts_are_all_driven_goes_through_a_run() -> None:
    shaft, heat = "motor.shaft_temperature", "motor.heat_flow"
    try:
        compilers(platforms_named(None))
    except InputError as fault:
        pytest.skip(str(fault))
    rollout = compiled(join("Alone", {"motor": MOTOR}, []), (shaft, heat))
    runs: list[dict[str, dict[str, float]]] = [{}, {"motor": {"initial_shaft_temperature": 310.0}}]
    values, well = rollout.run(runs, 100, 1.0)
    assert well.all()
    np.testing.assert_array_equal(values[0, 0], 295.15)
    assert 295.15 < values[1, 0, -1] < values[1, 0, 0] == 310.0

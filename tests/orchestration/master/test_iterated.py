"""Iterations that find nothing say so."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from warmlink.orchestration.master.algorithms.doubling import StepDoubling
from warmlink.orchestration.master.algorithms.iterated import FixedPoint, InterfaceNewton, Iterated
from warmlink.orchestration.master.run import simulate

from .pairs import assembly, counter, gain, wire

WITHOUT_SOLUTION = [lambda x: x + 0.1, lambda x: x - 12.0, lambda x: x + 1.0 + 0.5 * np.sin(x)]


@pytest.mark.parametrize("answer", WITHOUT_SOLUTION)
@pytest.mark.parametrize("chosen", [FixedPoint(), InterfaceNewton()], ids=str)
def test_where_there_is_no_solution_nothing_is_found(
    chosen: Iterated, answer: Callable[[np.ndarray], np.ndarray]
) -> None:
    """Iterates ran away until what was left was small beside them, or a singular matrix ended the run."""
    found, _ = chosen.solve(answer, np.zeros(1), np.ones(1), None)
    assert not found


@pytest.mark.parametrize("chosen", [FixedPoint(), InterfaceNewton()], ids=str)
def test_what_is_far_from_its_nominal_value_is_found(chosen: Iterated) -> None:
    found, _ = chosen.solve(lambda x: 0.5 * x + 5e6, np.zeros(1), np.ones(1), None)
    assert found


@pytest.mark.parametrize("add", [0.0, 0.1, -0.37])
@pytest.mark.parametrize("chosen", [FixedPoint(), InterfaceNewton()], ids=str)
def test_a_step_without_a_solution_is_repeated_in_smaller_parts(chosen: Iterated, add: float) -> None:
    """y' = y + add by steps of 2 s, of which the trapezoidal rule has no solution; halved, it has."""
    system = assembly([counter("a"), gain("b", 1.0)], wire("a.y -> b.u"), wire("b.y -> a.u", offset=add))
    result = simulate(system, 4.0, 2.0, chosen)
    assert result.status == "completed"
    assert result["a.y"] == pytest.approx(add * (9.0 ** np.arange(3) - 1))


def test_errors_of_slaves_that_exchange_nothing_are_none() -> None:
    system = assembly([counter("a"), counter("b")])
    result = simulate(system, 4.0, 1.0, StepDoubling(InterfaceNewton(), {}))
    assert result.status == "completed"
    assert result["a.y"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]

"""Discarded steps are repeated smaller, the rest of the run being as if nothing had happened."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel, Jacobi
from warmlink.orchestration.master.algorithms.parts import Retry
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.system.description import Capabilities
from warmlink.orchestration.system.model import FmuPart, System

from .mock import MockSlave
from .pairs import assembly, counter, wire


def choosy(largest: float, after: float, **options: Any) -> MockSlave:
    """x' = u, but from `after` on no step longer than `largest` is taken."""

    def advance(x: float, u: Any, t: float, h: float) -> float:
        if t >= after and h > largest:
            raise SlaveError("choosy", "discard", t, "too long a step")
        return x + h * u["u"]

    return MockSlave(
        "choosy", inputs={"u": 1.0}, outputs={"y": lambda x, u, t: x}, state=0.0, advance=advance, **options
    )


def test_smaller_steps_are_tried_and_the_others_go_back_with_it() -> None:
    slaves = [counter("x"), choosy(0.3, after=100.0)]
    wires = (wire("x.y -> choosy.u"), wire("choosy.y -> x.u", factor=-1e-3, offset=1.0))
    retried = simulate(assembly(slaves, *wires), 150.0, 1.0, Jacobi())
    assert retried.status == "completed"
    assert retried.statistics.rejected_steps > 0
    # Until the first discard it is the plain run bit for bit, and then that of quarter steps.
    plain = simulate(assembly([counter("x"), choosy(9, after=0)], *wires), 150.0, 1.0, Jacobi())
    np.testing.assert_array_equal(retried.table.values[:101], plain.table.values[:101])
    # From there on it is the recursion with quarter steps (0.5 s is discarded, too).
    x, y = retried["x.y"][100], retried["choosy.y"][100]
    for row in range(101, 105):
        for _ in range(4):
            x, y = x + 0.25 * (1.0 - 1e-3 * y), y + 0.25 * x
        assert (retried["x.y"][row], retried["choosy.y"][row]) == (x, y)


def test_the_minimum_is_stated_when_it_does_not_help() -> None:
    result = simulate(assembly([choosy(0.1, after=10.0)]), 20.0, 1.0, Retry(GaussSeidel(), minimum_step=0.25))
    assert result.reason == (
        "choosy: discard at 10 s: too long a step; smaller steps were tried, down to 0.25 s"
    )
    assert result.times[-1] == 10.0
    with pytest.raises(InputError, match="minimum step: 2 s is not above 0 s and at most"):
        simulate(assembly([choosy(0.1, after=10.0)]), 20.0, 1.0, Retry(GaussSeidel(), minimum_step=2.0))


def test_a_slave_without_restore_is_named_as_the_reason_not_to_try() -> None:
    slaves = [counter("x", capabilities=Capabilities(variable_step=True)), choosy(0.1, after=3.0)]
    result = simulate(assembly(slaves), 20.0, 1.0)
    assert "no smaller step could be tried, for x cannot restore its state" in str(result.reason)
    assert result.times[-1] == 3.0


def test_native_slaves_are_retried(trivial2: Path) -> None:
    parameters = {"largest_step": 0.25}
    system = System("s", {"a": FmuPart("a", trivial2), "b": FmuPart("b", trivial2, {}, parameters)})
    result = simulate(system, 50.0, 1.0)
    assert result.status == "completed"
    np.testing.assert_allclose(result["b.y"], result.times)
    assert result["b.steps"][-1] == 200
    # Once warned, the master goes carefully and does not run into every discard again.
    assert result.statistics.rejected_steps <= 10

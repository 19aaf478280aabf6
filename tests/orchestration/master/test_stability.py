"""An unstable step size is called so, a stable one is not."""

from __future__ import annotations

import numpy as np
import pytest

from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel, Jacobi
from warmlink.orchestration.master.algorithms.iterated import FixedPoint
from warmlink.orchestration.master.run import simulate

from .mock import MockSlave
from .motor_link import monolithic, motor_link
from .pairs import assembly, counter, wire

CASES = [
    (Jacobi(), 1.0, (1.0, 10.0, 20.0, 30.0, 40.0, 60.0)),
    (Jacobi(settled=True), 1.0, (10.0, 30.0, 40.0, 60.0)),
    (GaussSeidel(), 1.0, (10.0, 30.0, 40.0, 60.0)),
    (GaussSeidel(), 50.0, (1.0, 60.0)),
    (Jacobi(), 50.0, (1.0,)),
]


@pytest.mark.parametrize(("chosen", "joint", "steps"), CASES, ids=str)
def test_what_is_called_unstable_is_what_diverges(
    chosen: Algorithm, joint: float, steps: tuple[float, ...]
) -> None:
    for step in steps:
        with np.errstate(all="ignore"):
            result = simulate(motor_link(joint), 7200.0, step, chosen, record=["link.elongation"])
        worst = np.max(
            np.abs(result["link.elongation"] - monolithic(joint, 7200.0, step)[: len(result.times)])
        )
        # A coupling error of 5 µm of 88 is no step size's order of accuracy any more.
        diverges = result.status == "stopped" or worst > 5e-6
        assert any("is unstable here with steps of" in remark for remark in result.remarks) == diverges


def test_the_remark_says_what_to_do() -> None:
    (remark,) = simulate(motor_link(1.0), 7200.0, 60.0, GaussSeidel()).remarks
    assert remark.startswith(
        "GaussSeidel is unstable here with steps of 60 s: a disturbance of the exchanged"
    )
    assert remark.endswith("take smaller steps or an iterated algorithm")
    assert simulate(motor_link(1.0), 7200.0, 60.0, FixedPoint()).remarks == ()


def test_integrators_in_a_row_are_not_unstable() -> None:
    slaves = [counter("a"), counter("b"), counter("c")]
    result = simulate(assembly(slaves, wire("a.y -> b.u"), wire("b.y -> c.u")), 300.0, 1.0, Jacobi())
    assert result.remarks == ()


def test_a_nan_from_nowhere_is_not_called_instability() -> None:
    broken = MockSlave(
        "broken",
        inputs={"u": 0.0},
        outputs={"y": lambda x, u, t: float("nan") if t > 6.0 else x},
        state=1.0,
        advance=lambda x, u, t, h: x,
    )
    wires = wire("broken.y -> a.u"), wire("a.y -> broken.u")
    result = simulate(assembly([broken, counter("a")], *wires), 20.0, 1.0, Jacobi())
    assert result.status == "stopped"
    assert "the output is nan" in str(result.reason)
    assert result.remarks == ()

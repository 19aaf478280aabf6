"""Which signals are continuous, what is iterated, and polynomials through points."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from warmlink.orchestration.master.algorithms.iterated import FixedPoint
from warmlink.orchestration.master.algorithms.polynomials import derivatives, value_at
from warmlink.orchestration.master.algorithms.structure import is_sampled, plan
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.network import Network

from .mock import MockSlave, real
from .motor_link import motor_link
from .pairs import assembly, counter, wire

finite = st.floats(-10, 10)


@given(finite, finite, finite, st.floats(0.1, 5), st.floats(-5, -0.1))
def test_polynomials_are_recovered(a: float, b: float, c: float, ahead: float, behind: float) -> None:
    def f(t: float) -> float:
        return a + b * t + c * t * t

    points = [(0.0, f(0.0)), (ahead, f(ahead)), (behind, f(behind))]
    first, second = derivatives(points)
    assert first == pytest.approx(b, abs=1e-6)
    assert second == pytest.approx(2 * c, abs=1e-6)
    assert value_at(points, 0.7) == pytest.approx(f(0.7), abs=1e-6)
    assert derivatives(points[:1]) == (0.0, 0.0)


def sampler(name: str) -> MockSlave:
    """Keeps the input of the last step's end; its output is discrete."""
    return MockSlave(
        name,
        inputs={"u": 0.0},
        outputs={"y": lambda x, u, t: x},
        state=0.0,
        advance=lambda x, u, t, h: u["u"],
        variables=[real("y", "output", variability="discrete")],
    )


def test_only_continuous_loops_are_iterated() -> None:
    pair = motor_link()
    slaves = [*pair.slaves, sampler("camera"), sampler("law")]
    wires = [
        *pair.connections,
        wire("link.elongation -> camera.u"),
        wire("camera.y -> law.u"),
    ]
    network = Network(slaves, wires)
    found = plan(network)
    assert [is_sampled(s) for s in slaves] == [False, False, True, True]
    (loop,) = found.groups
    assert set(loop.members) == {0, 1}
    assert len(loop.torn) == 1
    assert found.sampled == (2, 3)


def test_groups_follow_their_sources_and_need_no_iteration_without_a_loop() -> None:
    slaves = [counter("c"), counter("b"), counter("a")]
    network = Network(slaves, [wire("a.y -> b.u"), wire("b.y -> c.u")])
    assert [g.members for g in plan(network).groups] == [(2,), (1,), (0,)]
    result = simulate(assembly(slaves, wire("a.y -> b.u"), wire("b.y -> c.u")), 4.0, 0.5, FixedPoint(2))
    # a = t; b' = a, c' = b, with inputs of degree two: exact once there is enough past.
    np.testing.assert_allclose(result["b.y"], result.times**2 / 2, atol=1e-12)
    np.testing.assert_allclose(result["c.y"], result.times**3 / 6, atol=0.03)
    assert result.statistics.slave_steps == 24


def test_discrete_signals_are_held_during_a_step() -> None:
    # The duty's output changes at communication points: a slave behind it must not see the change early.
    duty = MockSlave(
        "duty",
        outputs={"y": lambda x, u, t: 1.0 if t >= 2.0 else 0.0},
        variables=[real("y", "output", variability="discrete")],
    )
    result = simulate(assembly([duty, counter("x")], wire("duty.y -> x.u")), 4.0, 1.0, FixedPoint())
    np.testing.assert_array_equal(result["x.y"], [0, 0, 0, 1, 2])

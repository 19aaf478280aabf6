"""Jacobi and Gauss-Seidel on mocks: what exactly is exchanged when."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel, Jacobi
from warmlink.orchestration.master.algorithms.structure import feedthrough_order
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.result import Balance
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.system.model import INTEGER_RANGES

from .mock import MockSlave, real
from .pairs import assembly, counter, gain, wire


def test_jacobi_reads_feedthrough_with_the_old_input_at_the_new_time() -> None:
    # x' = 1 from 0, g = 2 x at once: Jacobi reads g before the new x arrives, one step late.
    result = simulate(assembly([counter("x"), gain("g", 2.0)], wire("x.y -> g.u")), 3.0, 1.0, Jacobi())
    np.testing.assert_array_equal(result["x.y"], [0, 1, 2, 3])
    np.testing.assert_array_equal(result["g.y"], [0, 0, 2, 4])


def test_gauss_seidel_hands_fresh_values_on_within_the_step() -> None:
    slaves = [gain("g", 2.0), counter("x")]
    result = simulate(assembly(slaves, wire("x.y -> g.u")), 3.0, 1.0, GaussSeidel())
    np.testing.assert_array_equal(result["g.y"], [0, 2, 4, 6])
    slaves = [gain("g", 2.0), counter("x")]
    result = simulate(assembly(slaves, wire("x.y -> g.u")), 3.0, 1.0, GaussSeidel(("g", "x")))
    np.testing.assert_array_equal(result["g.y"], [0, 0, 2, 4])


def test_order_follows_feedthrough_and_breaks_cycles_the_same_way() -> None:
    motor = MockSlave(
        "motor",
        inputs={"base": 0.0},
        outputs={"flow": lambda x, u, t: -u["base"]},
        feedthrough={"flow": ["base"]},
    )
    link = MockSlave("link", inputs={"flow": 0.0}, outputs={"base": lambda x, u, t: 0.0})
    wires = (wire("motor.flow -> link.flow"), wire("link.base -> motor.base"))
    network = Network([motor, link], wires)
    assert feedthrough_order(network) == (1, 0)
    loop = [gain(n, 0.5) for n in "abc"]
    network = Network(loop, [wire("a.y -> b.u"), wire("b.y -> c.u"), wire("c.y -> a.u")])
    assert feedthrough_order(network) == (0, 1, 2)


def test_an_order_must_name_each_slave_once() -> None:
    slaves = [gain("g", 2.0), counter("x")]
    with pytest.raises(InputError, match="name each of them once"):
        simulate(assembly(slaves, wire("x.y -> g.u")), 3.0, 1.0, GaussSeidel(("g", "g")))
    assert all(s.terminated for s in slaves)


def test_connections_convert_and_reach_start_values() -> None:
    slaves = [counter("x"), gain("g", 1.0)]
    result = simulate(
        assembly(slaves, wire("x.y -> g.u", factor=1000.0, offset=-5.0), x={"u": 0.5}),
        2.0,
        1.0,
        GaussSeidel(),
    )
    np.testing.assert_array_equal(result["g.y"], [-5.0, 495.0, 995.0])


def test_initialization_settles_a_loop_of_feedthrough() -> None:
    # a = 1 + 0.5 b, b = 0.8 a: a = 1 / 0.6
    a = MockSlave(
        "a",
        inputs={"u": 0.0},
        outputs={"y": lambda x, u, t: 1 + 0.5 * u["u"]},
        feedthrough={"y": ["u"]},
    )
    result = simulate(assembly([a, gain("b", 0.8)], wire("a.y -> b.u"), wire("b.y -> a.u")), 1.0, 1.0)
    assert result["a.y"][0] == pytest.approx(1 / 0.6, rel=1e-11)
    assert result.statistics.initialization_sweeps > 5


def test_a_loop_that_does_not_settle_is_named() -> None:
    a = MockSlave(
        "a",
        inputs={"u": 0.0},
        outputs={"y": lambda x, u, t: 1 - 1.5 * u["u"]},
        feedthrough={"y": ["u"]},
    )
    result = simulate(assembly([a, gain("b", 1.0)], wire("a.y -> b.u"), wire("b.y -> a.u")), 1.0, 1.0)
    assert result.status == "stopped"
    assert "do not settle" in str(result.reason)
    assert len(result.times) == 0


def failing(time_of_failure: float) -> MockSlave:
    def advance(x: float, u: object, t: float, h: float) -> float:
        if t >= time_of_failure:
            raise SlaveError("f", "error", t, "no more")
        return x + h

    return MockSlave("f", outputs={"y": lambda x, u, t: x}, state=0.0, advance=advance)


def test_an_error_ends_the_run_and_keeps_what_was_recorded() -> None:
    slaves = [counter("x"), failing(2.5)]
    result = simulate(assembly(slaves), 10.0, 0.5, Jacobi())
    assert result.status == "stopped"
    assert result.reason == "f: error at 2.5 s: no more"
    np.testing.assert_array_equal(result.times, np.arange(6) * 0.5)
    np.testing.assert_array_equal(result["f.y"], np.arange(6) * 0.5)
    assert all(s.terminated for s in slaves)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
@pytest.mark.parametrize("algorithm", [Jacobi(), GaussSeidel()])
def test_a_value_that_is_not_finite_is_caught_where_it_came_from(
    bad: float, algorithm: Jacobi | GaussSeidel
) -> None:
    source = MockSlave("s", outputs={"y": lambda x, u, t: bad if t >= 3 else 1.0})
    result = simulate(assembly([source, gain("g", 1.0)], wire("s.y -> g.u")), 5.0, 1.0, algorithm)
    assert result.error is not None
    assert (result.error.slave, result.error.variable, result.error.time) == ("s", "y", 3.0)
    assert result.error.status == "not finite"
    assert len(result.times) == 3


def test_an_input_may_declare_that_it_accepts_nan() -> None:
    source = MockSlave("s", outputs={"y": lambda x, u, t: math.nan})
    taker = MockSlave(
        "g",
        inputs={"u": 0.0},
        outputs={"y": lambda x, u, t: -1.0 if math.isnan(u["u"]) else u["u"]},
        feedthrough={"y": ["u"]},
        accepts_nan=frozenset({"u"}),
    )
    result = simulate(assembly([source, taker], wire("s.y -> g.u")), 2.0, 1.0, GaussSeidel())
    assert result.status == "completed"
    np.testing.assert_array_equal(result["g.y"], [-1, -1, -1])


def test_an_unconnected_output_that_is_recorded_must_be_finite_too() -> None:
    source = MockSlave("s", outputs={"y": lambda x, u, t: math.nan})
    assert simulate(assembly([source]), 1.0, 1.0).status == "stopped"
    source = MockSlave("s", outputs={"y": lambda x, u, t: math.nan}, accepts_nan=frozenset({"y"}))
    assert simulate(assembly([source]), 1.0, 1.0).status == "completed"


def test_recording_is_a_choice_and_takes_inputs_too() -> None:
    slaves = [counter("x"), gain("g", 2.0)]
    result = simulate(assembly(slaves, wire("x.y -> g.u")), 2.0, 1.0, record=["g.u", "g.y"])
    assert result.table.names == ("g.u", "g.y")
    np.testing.assert_array_equal(result["g.u"], [0, 1, 2])
    with pytest.raises(KeyError, match="was not recorded"):
        result["x.y"]
    with pytest.raises(InputError, match=r"x\.z: no slave has such a variable"):
        simulate(assembly([counter("x")]), 2.0, 1.0, record=["x.z"])


def test_columns_carry_units() -> None:
    link = MockSlave(
        "link",
        outputs={"elongation": lambda x, u, t: 1e-6 * t},
        variables=[real("elongation", "output", unit="m")],
    )
    frame = simulate(assembly([link]), 2.0, 1.0).to_frame()
    assert list(frame.columns) == ["time [s]", "link.elongation [m]"]
    assert frame["link.elongation [m]"].iloc[-1] == pytest.approx(2e-6)


@pytest.mark.parametrize(("given", "taken"), [("Int32", "Int8"), ("UInt64", "Int32"), ("Integer", "UInt8")])
def test_a_number_that_an_input_cannot_hold_is_not_cut_to_its_last_bits(given: str, taken: str) -> None:
    source = MockSlave(
        "s",
        outputs={"y": lambda x, u, t: round(10.0**t)},
        variables=[replace(real("y", "output", variability="discrete"), type=given, kind="Integer")],
    )
    sink = MockSlave(
        "g",
        inputs={"u": 0},
        variables=[replace(real("u", "input", variability="discrete"), type=taken, kind="Integer")],
    )
    result = simulate(assembly([source, sink], wire("s.y -> g.u")), 12.0, 1.0, record=["g.u"])
    least, most = INTEGER_RANGES[taken]
    last = max(n for n in range(13) if 10**n <= most)
    assert result["g.u"].tolist() == [10**n for n in range(last + 1)]
    told = f"{10 ** (last + 1)} is sent to it, but {taken} holds {least} to {most} alone"
    assert result.reason == f"g.u: error at {last + 1} s: {told}"


def test_heat_balance_is_found_and_audited_per_step() -> None:
    # The link takes 90 % of what it is given.
    motor = MockSlave(
        "motor",
        outputs={"heat_flow": lambda x, u, t: 5.0, "heat_delivered": lambda x, u, t: x},
        state=0.0,
        advance=lambda x, u, t, h: x + 5.0 * h,
    )
    link = MockSlave(
        "link",
        inputs={"heat_flow": 0.0},
        outputs={"heat_received": lambda x, u, t: x},
        state=0.0,
        advance=lambda x, u, t, h: x + 0.9 * u["heat_flow"] * h,
    )
    result = simulate(assembly([motor, link], wire("motor.heat_flow -> link.heat_flow")), 4.0, 2.0, record=[])
    (found,) = result.audits
    assert found.balance == Balance("motor.heat_delivered", "link.heat_received")
    np.testing.assert_allclose(found.per_step, [1.0, 1.0])
    assert found.total == pytest.approx(2.0)
    assert found.delivered == pytest.approx(20.0)


def test_connections_that_cannot_be_are_refused_with_both_ends() -> None:
    with pytest.raises(InputError, match=r"x\.q -> g\.u: its source x\.q does not exist"):
        Network([counter("x"), gain("g", 1.0)], [wire("x.q -> g.u")])
    with pytest.raises(InputError, match="has another source already"):
        Network([counter("x"), gain("g", 1.0)], [wire("x.y -> g.u"), wire("g.y -> g.u")])
    with pytest.raises(InputError, match="two slaves have this name"):
        Network([counter("x"), counter("x")], [])


def test_times_are_multiples_and_a_step_must_divide() -> None:
    points = CommunicationPoints.between(0.0, 7200.0, 0.1)
    assert points.count == 72000
    assert points.stop_time == pytest.approx(7200.0, rel=1e-15)
    with pytest.raises(InputError, match="does not divide"):
        CommunicationPoints.between(0.0, 10.0, 3.0)
    for step in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InputError):
            CommunicationPoints.between(0.0, 10.0, step)


def test_progress_ends_at_the_end() -> None:
    seen: list[tuple[int, int]] = []
    simulate(assembly([counter("x")]), 1000.0, 1.0, progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (1000, 1000)
    assert 100 < len(seen) < 300


@pytest.mark.parametrize(
    ("duration", "step"), [(1e6, 3.0), (7200.0, 0.7), (1.0, 0.3), (123456.789, 7.0), (1.0, 5.0)]
)
def test_the_step_that_is_proposed_is_taken(duration: float, step: float) -> None:
    with pytest.raises(InputError) as refusal:
        CommunicationPoints.between(0.0, duration, step)
    proposed = str(refusal.value).rpartition("choose one that does, ")[2].partition(" s for")[0]
    assert CommunicationPoints.between(0.0, duration, float(proposed)).count >= 1

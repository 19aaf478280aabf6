"""Motor and link against the exact solution of both together: figures and orders in the step size."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.doubling import StepDoubling
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel, Jacobi
from warmlink.orchestration.master.algorithms.iterated import FixedPoint, InterfaceNewton
from warmlink.orchestration.master.algorithms.named import about, algorithm, masters
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.description import Capabilities

from .mock import Inputs, MockSlave, real
from .motor_link import monolithic, motor_link
from .pairs import assembly, counter, wire


@lru_cache(maxsize=128)
def error(chosen: Algorithm, step: float, joint: float = 1.0, stop: float = 7200.0) -> float:
    """Largest elongation error in µm."""
    with np.errstate(over="ignore", invalid="ignore"):
        result = simulate(motor_link(joint), stop, step, chosen, record=["link.elongation"])
        if result.status != "completed":
            return np.inf
        return float(np.max(np.abs(result["link.elongation"] - monolithic(joint, stop, step)))) * 1e6


def test_the_exact_pair_meets_the_independent_figures() -> None:
    exact = monolithic(1.0, 7200.0, 600.0) * 1e6
    np.testing.assert_allclose(exact[[1, 3, 6, 12]], [14.07, 49.95, 75.77, 87.95], rtol=1e-3)


@pytest.mark.parametrize(
    ("chosen", "steps", "joint", "stop", "order"),
    [
        (Jacobi(), (2.0, 4.0, 8.0), 1.0, 3600.0, 1),
        (Jacobi(settled=True), (2.0, 4.0, 8.0), 1.0, 3600.0, 1),
        (GaussSeidel(), (2.0, 4.0, 8.0), 1.0, 3600.0, 1),
        (GaussSeidel(("motor", "link")), (2.0, 4.0, 8.0), 1.0, 3600.0, 1),
        (FixedPoint(interpolation=0), (5.0, 10.0, 20.0), 1.0, 3600.0, 1),
        (FixedPoint(interpolation=0), (5.0, 10.0, 20.0), 50.0, 3600.0, 1),
        (FixedPoint(interpolation=1), (15.0, 30.0, 60.0), 1.0, 3600.0, 2),
        (FixedPoint(interpolation=2, tolerance=1e-13), (0.0625, 0.125, 0.25), 1.0, 10.0, 3),
        (InterfaceNewton(interpolation=1), (15.0, 30.0, 60.0), 1.0, 3600.0, 2),
        (InterfaceNewton(interpolation=2, tolerance=1e-13), (0.0625, 0.125, 0.25), 1.0, 10.0, 3),
    ],
    ids=str,
)
def test_order_of_convergence(
    chosen: Algorithm, steps: tuple[float, ...], joint: float, stop: float, order: int
) -> None:
    errors = [error(chosen, h, joint, stop) for h in steps]
    observed = np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert chosen.order == order
    np.testing.assert_allclose(observed, order, atol=0.25)


# A study with exact sub-solvers, in µm at steps of 1, 10, 30 and 60 s; None where the same is shown by
# another line already, or by the order.
STUDY = [
    (Jacobi(settled=True), 1.0, (None, 0.10, 0.31)),
    (GaussSeidel(("motor", "link")), 1.0, (None, 0.41, 1.2)),
    (GaussSeidel(), 1.0, (0.0072, 0.072, 0.22)),
    (FixedPoint(interpolation=0), 1.0, (None, 0.11, 0.32, 0.64)),
    (FixedPoint(interpolation=1), 1.0, (0.00002, 0.0015, 0.015, 0.064)),
    (InterfaceNewton(interpolation=1), 1.0, (None, 0.0015, 0.015, 0.064)),
    (FixedPoint(interpolation=1), 50.0, (None, 0.008, 0.06, 0.22)),
    (FixedPoint(interpolation=2), 50.0, (None, 0.008, 0.06, 0.22)),
    (InterfaceNewton(interpolation=1), 50.0, (None, 0.008, 0.06, 0.22)),
]


@pytest.mark.parametrize(("chosen", "joint", "figures"), STUDY, ids=str)
def test_the_figures_of_the_study_are_reached_or_better(
    chosen: Algorithm, joint: float, figures: tuple[float | None, ...]
) -> None:
    for step, figure in zip((1.0, 10.0, 30.0, 60.0), figures, strict=False):
        assert figure is None or error(chosen, step, joint) <= figure


def test_held_inputs_diverge_where_the_joint_conducts_well() -> None:
    assert error(Jacobi(), 1.0, 50.0) > 1e6
    assert error(GaussSeidel(), 1.0, 50.0) > 1e6
    assert error(Jacobi(), 60.0) > 1e6


def test_a_slave_without_input_derivatives_gets_the_mean() -> None:
    able, plain = (
        Capabilities(variable_step=True, get_set_state=True, interpolate_inputs=varies)
        for varies in (True, False)
    )

    def order(pair: tuple[Capabilities, Capabilities], coarse: float, stop: float = 1800.0) -> float:
        errors = []
        for step in (coarse / 2, coarse):
            result = simulate(motor_link(1.0, pair), stop, step, FixedPoint(), record=["link.elongation"])
            errors.append(np.max(np.abs(result["link.elongation"] - monolithic(1.0, stop, step))))
        return float(np.log2(errors[1] / errors[0]))

    assert order((plain, able), 8.0) == pytest.approx(2.0, abs=0.1)
    # The heat flow enters a link whose fastest cells answer within a second: order two below that, the
    # three halves of diffusion above.
    assert order((able, plain), 0.5, 300.0) == pytest.approx(2.0, abs=0.1)
    assert order((able, plain), 20.0) == pytest.approx(1.5, abs=0.1)


def test_a_slave_without_state_restore_gets_what_is_possible_and_a_sentence() -> None:
    plain = Capabilities(variable_step=True, interpolate_inputs=True)
    able = Capabilities(variable_step=True, get_set_state=True, interpolate_inputs=True)
    result = simulate(motor_link(1.0, (plain, able)), 3600.0, 10.0, FixedPoint(), record=["link.elongation"])
    assert result.status == "completed"
    assert result.remarks[0].startswith("motor: cannot restore its state, so it is stepped once, after link")
    assert np.max(np.abs(result["link.elongation"] - monolithic(1.0, 3600.0, 10.0))) < 1e-6


@pytest.mark.parametrize("joint", [1.0, 50.0])
@pytest.mark.parametrize("tolerance", [1e-9, 1e-7])
def test_step_doubling_keeps_the_tolerance_asked_for(joint: float, tolerance: float) -> None:
    chosen = StepDoubling(FixedPoint(), {"link.elongation": tolerance}, minimum_step=1e-3)
    result = simulate(motor_link(joint), 7200.0, 60.0, chosen, record=["link.elongation"])
    assert result.status == "completed"
    worst = np.max(np.abs(result["link.elongation"] - monolithic(joint, 7200.0, 60.0)))
    assert worst <= tolerance
    # The control does not buy this with steps that nobody needs.
    assert result.statistics.slave_steps < 40_000


def test_step_doubling_makes_an_unstable_step_stable() -> None:
    chosen = StepDoubling(Jacobi(), {"link.elongation": 1e-6}, minimum_step=1e-3)
    result = simulate(motor_link(1.0), 3600.0, 60.0, chosen, record=["link.elongation"])
    assert np.max(np.abs(result["link.elongation"] - monolithic(1.0, 3600.0, 60.0))) <= 1e-6
    assert result.statistics.rejected_steps > 0
    assert result.statistics.limits_the_step == "link"


@pytest.mark.parametrize("variability", ["discrete", "continuous"])
def test_a_jump_within_a_step_is_located(variability: str) -> None:
    # y' = u, and u jumps at 1/3 of a communication step, where no comparison of two results shows it. Some
    # FMUs declare such an output continuous, for that is what a Real is unless its maker says otherwise.
    def duty() -> MockSlave:
        return MockSlave(
            "duty",
            outputs={"y": lambda x, u, t: 0.0 if t < 30.0 + 10.0 / 3 else 1.0},
            variables=[real("y", "output", variability=variability)],
        )

    exact = 10.0 - 10.0 / 3
    wires = (wire("duty.y -> x.u"),)
    plain = simulate(assembly([duty(), counter("x")], *wires), 60.0, 10.0, FixedPoint())
    assert abs(plain["x.y"][4] - exact) > 1.0
    chosen = StepDoubling(FixedPoint(), {"x.y": 0.01}, minimum_step=0.001)
    located = simulate(assembly([duty(), counter("x")], *wires), 60.0, 10.0, chosen)
    assert located["x.y"][4] == pytest.approx(exact, abs=0.01)
    assert located.statistics.slave_steps < 500
    # What is declared continuous stands in the way as an error of what it drives.
    assert located.statistics.limits_the_step == ("duty" if variability == "discrete" else "x")


@pytest.mark.parametrize(
    ("inner", "tolerance", "step"),
    [(InterfaceNewton(), 1e-2, 1.0), (Jacobi(), 1e-1, 1.0), (Jacobi(), 1e-1, 15.0)],
    ids=str,
)
@pytest.mark.parametrize("onset", [30.001, 30.3, 38.0])
def test_what_begins_to_move_late_is_compared_at_once(
    inner: Algorithm, tolerance: float, step: float, onset: float
) -> None:
    # At rest, comparisons find no error; a signal without jumps then moves two integrators in a loop. With
    # held inputs they do so one step later each, where no comparison of two results shows it.
    def source() -> MockSlave:
        return MockSlave("source", outputs={"y": lambda x, u, t: max(0.0, t - onset)})

    def integrator(name: str, sign: float) -> MockSlave:
        def advance(x: float, u: Inputs, t: float, h: float) -> float:
            return x + sum(
                factor * (c[0] * h + c[1] * h**2 / 2 + c[2] * h**3 / 6)
                for factor, c in ((sign, u.coefficients("u")), (1.0, u.coefficients("push")))
            )

        return MockSlave(
            name,
            inputs={"u": 0.0, "push": 0.0},
            outputs={"y": lambda x, u, t: float(x)},
            state=0.0,
            advance=advance,
        )

    wires = (wire("source.y -> a.push"), wire("a.y -> b.u"), wire("b.y -> a.u"))
    slaves = [source(), integrator("a", -1.0), integrator("b", 1.0)]
    chosen = StepDoubling(inner, {"a.y": tolerance}, minimum_step=1e-5)
    result = simulate(assembly(slaves, *wires), 45.0, step, chosen)
    exact = 1.0 - np.cos(np.maximum(0.0, result.times - onset))
    assert np.max(np.abs(result["a.y"] - exact)) <= tolerance


def test_a_minimum_step_that_does_not_suffice_is_said() -> None:
    chosen = StepDoubling(FixedPoint(), {"link.elongation": 1e-15}, minimum_step=30.0)
    result = simulate(motor_link(1.0), 3600.0, 60.0, chosen)
    assert "smallest step of 30 s the estimated error is still" in str(result.reason)


def test_algorithms_have_names() -> None:
    assert algorithm("interface_newton") == InterfaceNewton()
    with pytest.raises(InputError, match=r"'euler' is not known; choose .*jacobi, "):
        algorithm("euler")


@pytest.mark.parametrize("name", masters())
def test_every_named_algorithm_runs_the_pair(name: str) -> None:
    assert about(name)
    assert error(algorithm(name), 0.5, stop=60.0) < 0.05

"""The bound from a run with half the step against the true coupling error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warmlink.orchestration.master.algorithms import ERROR_CONTROLLED
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel, Jacobi
from warmlink.orchestration.master.algorithms.iterated import FixedPoint
from warmlink.orchestration.master.algorithms.named import algorithm
from warmlink.orchestration.master.error_budget import (
    ATTEMPTS,
    _ways,
    attempted,
    coupling_error,
    unseen_in,
)
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.slave import SlaveError

from .mock import Inputs, MockSlave
from .motor_link import monolithic, motor_link
from .pairs import assembly, counter, wire

E = "link.elongation"


def run(joint: float, stop: float, step: float, chosen: Algorithm) -> Result:
    return simulate(motor_link(joint), stop, step, chosen, record=[E])


def test_the_bound_covers_the_true_error_without_exaggerating() -> None:
    random = np.random.default_rng(20)
    covered, close, count = 0, 0, 20
    for _ in range(count):
        chosen = [Jacobi(), GaussSeidel(), FixedPoint()][random.integers(3)]
        joint = float(np.exp(random.uniform(np.log(0.2), np.log(2.0))))
        step = float(random.choice([4.0, 6.0, 10.0]))
        coarse = run(joint, 600.0, step, chosen)
        bound = coupling_error(coarse, run(joint, 600.0, step / 2, chosen), chosen.order, [E])[E]
        truth = np.max(np.abs(coarse[E] - monolithic(joint, 600.0, step)))
        covered += truth <= bound
        close += bound <= 10 * truth
    assert covered >= 0.95 * count
    assert close >= 0.9 * count


def swinging(by: Algorithm, half: bool) -> Result:
    """A run of x'' = 1 - x from rest."""
    wires = (wire("x.y -> v.u", -1.0, 1.0), wire("v.y -> x.u"))
    return simulate(assembly([counter("x"), counter("v")], *wires), 3.0, 0.1 / (1 + half), by)


def error_of_swinging(result: Result) -> float:
    return float(np.max(np.abs(result["x.y"] - 1 + np.cos(result.times))))


def test_the_bound_covers_the_true_error_of_steps_that_follow_the_error() -> None:
    found = attempted(algorithm(ERROR_CONTROLLED), {}, ["x.y"], swinging)
    truth = error_of_swinging(found.result)
    assert 0 < truth <= found.bounds["x.y"] <= 10 * truth


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-5])
def test_a_tolerance_is_kept_by_what_swings_and_never_forgets_an_error(tolerance: float) -> None:
    found = attempted(Jacobi(), {"x.y": tolerance}, ["x.y"], swinging)
    assert not found.missed
    assert error_of_swinging(found.result) <= found.bounds["x.y"] <= tolerance


def test_a_part_of_the_run_bounds_that_part() -> None:
    coarse = run(1.0, 1200.0, 4.0, GaussSeidel())
    part = coupling_error(coarse, run(1.0, 300.0, 2.0, GaussSeidel()), 1, [E])
    full = coupling_error(coarse, run(1.0, 1200.0, 2.0, GaussSeidel()), 1, [E])
    assert 0 < part[E] <= full[E]


def test_a_run_that_stopped_has_no_bound() -> None:
    with np.errstate(all="ignore"):
        coarse = run(50.0, 7200.0, 1.0, Jacobi())
    assert coarse.status == "stopped"
    assert coupling_error(coarse, coarse, 1, [E]) == {E: np.inf}


def test_what_moves_in_steps_as_long_as_those_of_the_run_hides_how_late_it_is() -> None:
    # y moves at whole seconds alone and the sum is a step late; with longer steps the two runs show it.
    def held() -> MockSlave:
        return MockSlave("a", outputs={"y": lambda x, u, t: float(np.sin(np.floor(t + 1e-9)))})

    def passing() -> MockSlave:
        return MockSlave("b", inputs={"u": 0.0}, outputs={"y": lambda x, u, t: 2.0 * u["u"]})

    def both(step: float) -> tuple[Result, Result]:
        coarse, fine = (
            simulate(assembly([held(), passing()], wire("a.y -> b.u")), 60.0, each, Jacobi(), record=["b.y"])
            for each in (step, step / 2)
        )
        return coarse, fine

    coarse, fine = both(1.0)
    assert np.max(np.abs(coarse["b.y"] - 2 * np.sin(coarse.times))) > 0.5
    assert coupling_error(coarse, fine, 1, ["b.y"]) == {"b.y": 0.0}
    assert unseen_in(fine, ["b.y"]) == ["b.y"]
    coarse, fine = both(2.0)
    assert coupling_error(coarse, fine, 1, ["b.y"])["b.y"] > 0.5
    assert unseen_in(fine, ["b.y"]) == []


def in_steps_of_its_own(by: Algorithm, step: float, stop: float = 60.0, square: float = 0.01) -> Result:
    """A run of x'' = square (1 - x) by slaves that step once a second, whatever steps they are asked for."""

    def integrator(name: str) -> MockSlave:
        def advance(x: tuple[float, float], u: Inputs, t: float, h: float) -> tuple[float, float]:
            value, own = x
            while own + 1.0 <= t + h + 1e-9:
                value, own = value + u["u"], own + 1.0
            return value, own

        return MockSlave(
            name,
            inputs={"u": 0.0},
            outputs={"y": lambda x, u, t: x[0]},
            state=(0.0, 0.0),
            advance=advance,
        )

    wires = (wire("x.y -> v.u", -square, square), wire("v.y -> x.u"))
    return simulate(assembly([integrator("x"), integrator("v")], *wires), stop, step, by, record=["x.y"])


def test_steps_shorter_than_those_of_an_fmus_own_show_nothing_of_its_lateness() -> None:
    coarse, fine = (in_steps_of_its_own(Jacobi(), step) for step in (0.75, 0.375))
    assert coupling_error(coarse, fine, 1, ["x.y"]) == {"x.y": 0.0}
    assert unseen_in(fine, ["x.y"]) == ["x.y"]
    coarse, fine = (in_steps_of_its_own(Jacobi(), step) for step in (4.0, 2.0))
    assert coupling_error(coarse, fine, 1, ["x.y"])["x.y"] > 0.1
    assert unseen_in(fine, ["x.y"]) == []


def test_a_tolerance_kept_by_such_steps_is_not_known_to_be() -> None:
    def once(by: Algorithm, half: bool) -> Result:
        return in_steps_of_its_own(by, 200.0 / (1 + half), 800.0, 1e-6)

    found = attempted(Jacobi(), {"x.y": 1e-6}, ["x.y"], once)
    assert found.bounds == {"x.y": 0.0}
    assert found.unseen == ["x.y"]


def failing(name: str) -> SlaveError:
    return SlaveError(name, "error", 0.0, "initialization failed")


@pytest.mark.parametrize("half", [False, True], ids=["at once", "at half the step"])
def test_a_later_attempt_that_fails_costs_no_earlier_one(half: bool) -> None:
    def once(by: Algorithm, halved: bool) -> Result:
        if by != GaussSeidel() and halved == half:
            raise failing("link")
        return run(1.0, 300.0, 4.0 / (1 + halved), by)

    found = attempted(GaussSeidel(), {E: 1e-12}, [E], once)
    assert found.result.status == "completed"
    assert (found.algorithm == GaussSeidel(), found.broken is None) == (not half, not half)
    assert list(found.missed) == [E]


def test_a_later_attempt_that_is_interrupted_costs_no_earlier_one_and_is_told() -> None:
    tried = list[Algorithm]()

    def once(by: Algorithm, halved: bool) -> Result:
        found = run(1.0, 300.0, 4.0 / (1 + halved), by)
        tried.append(by)
        if by == GaussSeidel():
            return found
        return replace(found, status="stopped", reason="interrupted at 20 s")

    found = attempted(GaussSeidel(), {E: 1e-12}, [E], once)
    assert found.result.status == "completed"
    assert found.stopped == "interrupted at 20 s in a run with smaller steps"
    assert len(tried) == 3


def test_a_first_attempt_that_fails_is_told() -> None:
    def once(by: Algorithm, halved: bool) -> Result:
        raise failing("link")

    with pytest.raises(SlaveError, match="initialization failed"):
        attempted(GaussSeidel(), {E: 1e-12}, [E], once)


def test_without_a_tolerance_there_is_one_way_alone() -> None:
    first = Jacobi()
    assert list(_ways(first, {}, [])) == [first]
    assert len(list(_ways(first, {"x.y": 1e-3}, []))) == 1 + ATTEMPTS

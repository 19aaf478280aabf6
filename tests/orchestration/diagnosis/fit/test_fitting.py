"""Fits stay within their bounds to the last bit: an FMU refuses an emissivity of -5e-17."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import warmlink as wl
from warmlink.orchestration.diagnosis.diagnose import read
from warmlink.orchestration.diagnosis.fit.algebra import bounded_step, orthonormal
from warmlink.orchestration.diagnosis.fit.candidates import FreeNumber
from warmlink.orchestration.diagnosis.fit.fitting import FitPoint, Fitter
from warmlink.orchestration.diagnosis.fit.neighbours import Neighbours
from warmlink.orchestration.diagnosis.fit.noise import NoiseModel
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.verdict import fitted_part
from warmlink.orchestration.diagnosis.model.simulation import NotSimulatedError


class Parabola(Fitter):
    """A chi-square with its least value below the lower bound or elsewhere; notes where it was asked."""

    def __init__(self, weight: float, start: float, least: float = -1.0) -> None:
        number = FreeNumber("link.emissivity", (0,), (0,), 0.1, 0.9, start, calibrated=True)
        self.problem = cast("Problem", SimpleNamespace(calibrated=(number,), out_of_time=lambda: False))
        self.weight, self.asked, self.least, self.count = weight, [start], least, 1

    def at(self, freed: Sequence[FreeNumber], theta: Any, every: bool = True) -> FitPoint:
        self.asked.append(float(theta[0]))
        away = self.least - theta[0]
        gram = np.array([[self.weight]])
        return FitPoint(self.weight * away**2, (gram,), (np.array([self.weight * away]),))


def test_no_step_leaves_the_bounds() -> None:
    random = np.random.default_rng(1)
    for _ in range(200):
        chi_square = Parabola(float(random.uniform(10, 1e5)), float(random.uniform(0.2, 0.8)))
        chi_square.fit(())
        assert 0.1 <= min(chi_square.asked) < 0.1 + 1e-12


def test_a_fit_ends_at_the_least_value_though_it_began_within_its_deviation() -> None:
    start = 0.5
    deviation = 1 / np.sqrt(400.0)
    fit = Parabola(400.0, start, start + 0.2 * deviation).fit(())
    assert fit.theta[0] == pytest.approx(start + 0.2 * deviation, abs=1e-9 * deviation)
    assert fit.chi2 == pytest.approx(0.0, abs=1e-9)
    assert fit.point.gradient[0] == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize("unit", [1e-10, 1.0, 1e10])
def test_no_number_stays_where_it_is_because_another_ones_unit_is_small(unit: float) -> None:
    """A camera's drift in m/s told a hundred billion times as much as a heat capacity, which then stayed."""
    columns = np.random.default_rng(4).standard_normal((50, 2)) / [unit, 1.0]
    wanted = np.array([0.3 * unit, -0.2])
    room = np.array([unit, 1.0])
    step, expected = bounded_step(columns.T @ columns, columns.T @ (columns @ wanted), -room, room)
    np.testing.assert_allclose(step, wanted, rtol=1e-6)
    assert expected == pytest.approx(np.sum((columns @ wanted) ** 2))
    assert orthonormal(columns).shape == (50, 2)


@pytest.mark.parametrize("size", [1e-9, 1e9, 1e10, 1e150])
def test_numbers_without_bounds_overflow_nothing(size: float) -> None:
    """Beyond a bound a run with a clamp on its link made 1e300 times a large derivative, with a warning."""
    gram, gradient, everywhere = np.array([[size**2]]), np.array([2 * size]), np.array([np.inf])
    with np.errstate(all="raise"):
        step, decrease = bounded_step(gram, gradient, -everywhere, everywhere)
    assert step == pytest.approx([2 / size])
    assert decrease == pytest.approx(4.0)


def test_what_changes_nothing_stays_where_it_is() -> None:
    step, _ = bounded_step(np.diag([2.0, 0.0]), np.array([1.0, 0.0]), np.full(2, -np.inf), np.full(2, np.inf))
    np.testing.assert_allclose(step, [0.5, 0.0])


class Cliff(Parabola):
    """The same, where nothing can be simulated below 0.3."""

    def at(self, freed: Sequence[FreeNumber], theta: Any, every: bool = True) -> FitPoint:
        if theta[0] < 0.3:
            raise NotSimulatedError("Machine: column: not finite")
        return super().at(freed, theta, every)


def test_values_with_which_nothing_can_be_simulated_are_kept_away_from() -> None:
    fit = Cliff(100.0, 0.8).fit(())
    assert 0.3 <= fit.theta[0] < 0.5
    number = fit.freed[0]
    again = Cliff(100.0, 0.8).fit((), {number: 0.2})
    assert 0.3 <= again.theta[0] < 0.5


@pytest.mark.filterwarnings("error")
def test_pairs_promise_the_same_however_large_a_candidates_unit_is() -> None:
    random = np.random.default_rng(3)
    columns, misfit = random.standard_normal((40, 5)), random.standard_normal(40)

    def pairs(scale: list[float]) -> list[tuple[int, ...]]:
        seen = columns * scale
        neighbours = Neighbours.__new__(Neighbours)
        neighbours.gram, neighbours.gradient = seen.T @ seen, seen.T @ misfit
        neighbours.alive, neighbours.spans = np.ones(5, dtype=bool), [slice(i, i + 1) for i in range(5)]
        return list(neighbours.pairs())

    assert pairs([1, 1e100, 1, 1e120, 1e-100]) == pairs([1, 1, 1, 1, 1])


def test_a_fit_knows_the_derivatives_by_every_slot_though_its_steps_need_those_of_its_own_numbers() -> None:
    """What similar sets of causes promise is told from them; on the way there they would only take time."""
    problem = Problem(fitted_part(read([wl.hide({"joint_resistance": 0.3}, seed=5)])))
    fitter = Fitter(problem, [NoiseModel(0.05)] * len(problem.variables))
    fit = fitter.fit([item for item in problem.items if item.title == "joint_resistance"])
    z = problem.values(0, fit.freed, fit.theta)
    (_, every), (_, own) = problem.predict(0, z), problem.predict(0, z, fit.freed)
    slots = list(fit.freed[0].slots)
    np.testing.assert_allclose(own[:, :, slots], every[:, :, slots], rtol=1e-9, atol=1e-12)
    assert not np.delete(own, slots, axis=2).any()
    np.testing.assert_array_equal(np.diag(fit.point.gram[0]) > 0, np.any(every != 0, axis=(0, 1)))

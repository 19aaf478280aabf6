"""The regression's law: intercept, smoothing, and what it says of its own error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from warmlink.controllers.interface import SENSED
from warmlink.controllers.matrices import packed_size
from warmlink.controllers.regression.component import COMPONENT
from warmlink.controllers.replay import ReplayedOutputs, replay
from warmlink.controllers.start_values import with_values
from warmlink.fmus.component import Component

Array = NDArray[np.float64]

BASE, TIP = SENSED.index("base_temperature"), SENSED.index("tip_temperature")


def law_with(**values: float | list[float]) -> Component:
    return replace(COMPONENT, parameters=with_values(COMPONENT.parameters, values))


def run(law: Component, temperature: Array) -> ReplayedOutputs:
    """The law over temperatures in K, a row for each second, shape (n, 5)."""
    starts = law.start_values()[1]
    rows = np.tile(starts, (len(temperature), 1))
    for i, name in enumerate(SENSED):
        rows[:, law.u.index[name]] = temperature[:, i]
    return replay(law, rows)


def warming(seconds: int, rate: float, noise: float = 0.0, seed: int = 1) -> Array:
    """Every place warms at a rate in K/s."""
    draw = np.random.default_rng(seed)
    time = np.arange(seconds)[:, None]
    return np.asarray(295.15 + rate * time + noise * draw.normal(size=(seconds, len(SENSED))))


def test_an_intercept_is_added() -> None:
    """With every temperature at the reference there may be growth: the probe's zero is anywhere."""
    draw = np.random.default_rng(2)
    still = 295.15 + 1e-3 * draw.normal(size=(600, 5))
    told, shifted = (run(law_with(intercept=each), still) for each in (0.0, 7e-6))
    assert shifted.correction[-1] - told.correction[-1] == pytest.approx(7e-6, abs=1e-9)


def test_noise_hardly_moves_the_tool_point() -> None:
    """In an hour it moved to and fro by 1,790 um with thermometers of 0.1 K; 100 um are allowed."""
    told = run(COMPONENT, warming(7200, 0.002, noise=0.1))
    travel = 1e6 * np.abs(np.diff(told.correction))[600:].sum() / (6600 / 3600)
    grown = 1e6 * abs(told.correction[-1] - told.correction[600]) / (6600 / 3600)
    assert travel - grown < 50


def test_it_is_not_late_for_growth_at_a_constant_rate() -> None:
    """Three smoothers of 15 s would be 45 s late: 0.6 um here."""
    rate = 0.002
    told = run(COMPONENT, warming(3600, rate))
    coefficients = COMPONENT.start_values()[0][[COMPONENT.p.index[f"coefficients[{i}]"] for i in range(1, 6)]]
    growth = coefficients.sum() * rate * np.arange(3600)
    assert np.abs(growth - told.correction)[600:].max() < 0.05 * 45 * rate * coefficients.sum()


def test_a_slower_smoother_moves_less() -> None:
    moved = [
        np.abs(np.diff(run(law_with(smoothing_time=each), warming(3600, 0.0, 0.1)).correction)).sum()
        for each in (5.0, 15.0, 45.0)
    ]
    assert moved[0] > 2 * moved[1] > 4 * moved[2]


def test_far_from_what_was_learnt_it_says_more_error() -> None:
    """The doubt about coefficients, and not the noise alone, decides on ready."""
    spread = np.zeros((5, 5))
    spread[BASE, BASE] = 0.3**2
    law = law_with(coefficient_spread=spread[np.triu_indices(5)].tolist())
    told = run(law, warming(9000, 0.003, noise=0.02))
    assert told.correction_std[-1] == pytest.approx(0.3e-6 * 27, rel=0.1)
    assert told.ready[600]
    assert not told.ready[-1]
    assert packed_size(5) == 15


def test_a_thermometer_that_fails_is_inferred_from_the_other_and_it_says_so() -> None:
    temperature = warming(3600, 0.003, noise=0.05)
    temperature[1800:, TIP] = np.nan
    as_modelled = law_with(coefficient_spread=[0.0] * 15)
    told, whole = (run(as_modelled, each) for each in (temperature, warming(3600, 0.003, noise=0.05)))
    assert told.distrusted[-1]
    assert told.correction_std[-1] > 3 * whole.correction_std[-1]
    assert np.isfinite(told.correction).all()


def test_a_law_that_was_learnt_starts_where_its_readings_say() -> None:
    """A warm start: within 5 um of the growth in a minute."""
    told = run(COMPONENT, warming(120, 0.0, noise=0.05) + 20.0)
    assert np.abs(told.correction[60:] - told.correction[-1]).max() < 5e-6


@pytest.mark.parametrize("leap", [1.0, -5.0])
def test_it_is_not_ready_once_thermometers_have_leapt_until_they_leap_back(leap: float) -> None:
    """No heat makes 1 K in a second. It was ready, and 7 um off, where both had leapt by as much."""
    temperature = warming(1200, 0.0, noise=0.05)
    temperature[100:600] += leap
    ready = run(law_with(coefficient_spread=[0.0] * 15), temperature).ready > 0
    assert ready[20:100].all()
    assert not ready[100:600].any()
    assert ready[-300:].all()


@pytest.mark.parametrize("heard", [0, 300])
def test_it_holds_its_correction_where_no_thermometer_tells_anything(heard: int) -> None:
    """After some minutes it told the mean growth of what it was learnt from: 46 um on a cold machine."""
    temperature = warming(2400, 0.0)
    temperature[heard:] = np.nan
    told = run(law_with(mean_rise=[20.0] * 5), temperature)
    assert told.correction[heard:] == pytest.approx(told.correction[heard - 1] if heard else 0.0, abs=1e-7)
    assert not told.ready[heard:].any()

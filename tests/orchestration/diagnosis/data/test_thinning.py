"""Averaged rows: what is simulated stands for what was measured, and its noise is told."""

from __future__ import annotations

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.data.thinning import MOST_ROWS, ROW, Averaging, thinned
from warmlink.orchestration.diagnosis.fit.noise import NoiseModel

VARIABLE = "link.tip_temperature"


def course(time: np.ndarray) -> np.ndarray:
    """Steep after a leap of the input, flat before."""
    return 300.0 + 30.0 * (1 - np.exp(-np.maximum(time - 40_005.0, 0.0) / 300.0))


def a_day(missing: slice = slice(0, 0)) -> Run:
    time = np.arange(0.0, 86_400.0, 10.0)
    noise = 0.05 * np.random.default_rng(4).standard_normal(time.size)
    readings = course(time) + noise
    readings[missing] = np.nan
    return Run("day", time, {}, {VARIABLE: readings})


def test_blocks_are_simulated_as_they_were_averaged() -> None:
    """Also where the inputs leap, and with a different number of rows from block to block."""
    found = thinned(a_day(), [VARIABLE])
    assert found.time.size <= MOST_ROWS + 1
    assert found.weight.sum(axis=1) == pytest.approx(1.0)
    simulated = np.sum(found.weight[:, :, 0] * course(found.within), axis=1)
    error = found.readings[:, 0] - simulated
    deviation = 0.05 / np.sqrt(found.averaging.rows)
    assert np.abs(error).max() < 5 * deviation
    assert np.std(error) == pytest.approx(deviation, rel=0.1)


def test_missing_rows_do_not_bend_a_mean() -> None:
    found = thinned(a_day(missing=slice(4008, 4014)), [VARIABLE])
    simulated = np.sum(found.weight[:, :, 0] * course(found.within), axis=1)
    assert np.abs(found.readings[:, 0] - simulated).max() < 0.1


def test_a_block_without_a_reading_is_simulated_all_the_same() -> None:
    time = np.arange(0.0, 3600.0, 2.0)
    readings = course(time)
    readings[100:121] = np.nan
    found = thinned(Run("gap", time, {}, {VARIABLE: readings}), [VARIABLE])
    assert np.isnan(found.readings[:, 0]).any()
    assert found.weight.sum(axis=1) == pytest.approx(1.0)


@pytest.mark.parametrize(("span", "every"), [(3600.0, 10), (86_400.0, 30)])
def test_an_output_that_is_logged_less_often_than_the_inputs_is_kept(span: float, every: int) -> None:
    time = np.arange(0.0, span, 1.0)
    readings = np.where(np.arange(time.size) % every == 0, course(time), np.nan)
    found = thinned(Run("loggers", time, {}, {VARIABLE: readings}), [VARIABLE])
    kept = np.isfinite(found.readings[:, 0])
    assert kept.sum() > min(0.9 * found.time.size, 0.9 * span / every)
    simulated = np.sum(found.weight[:, :, 0] * course(found.within), axis=1)
    assert np.abs(found.readings[:, 0] - simulated)[kept].max() < 0.1


def test_rows_that_are_not_dense_stay() -> None:
    time = np.arange(0.0, 3600.0, 10.0)
    found = thinned(Run("hour", time, {}, {VARIABLE: course(time)}), [VARIABLE])
    assert found.averaging == ROW
    assert np.array_equal(found.time, time)


def test_noise_of_a_mean_is_smaller_by_what_averaging_takes() -> None:
    """Against the variance of means of simulated noise: white, and correlated over a minute."""
    memory, interval, rows = 60.0, 1.0, 50
    draw = np.random.default_rng(7)
    decay = np.exp(-interval / memory)
    steps = np.sqrt(1 - decay**2) * draw.standard_normal(1_000_000)
    from scipy.signal import lfilter

    slow = lfilter([1.0], [1.0, -decay], steps).reshape(-1, rows).mean(axis=1)
    model = NoiseModel(0.3, 1.0, memory).averaged(Averaging(rows, rows * interval), ROW)
    assert model.white == pytest.approx(0.3 / np.sqrt(rows))
    assert model.slow == pytest.approx(slow.std(), rel=0.02)
    back = model.averaged(ROW, Averaging(rows, rows * interval))
    assert (back.white, back.slow) == pytest.approx((0.3, 1.0))


def test_a_stated_noise_is_that_of_any_reading() -> None:
    stated = NoiseModel(0.1, 0.0, 60.0, lasting=0.1)
    assert stated.averaged(Averaging(100, 100.0), ROW) == stated

"""Spikes: single readings that no heat makes, found without any model."""

from __future__ import annotations

import numpy as np

from tests.shared_data import given
from warmlink.orchestration.diagnosis.data.outliers import outliers
from warmlink.orchestration.diagnosis.data.signals import row_noise


def test_spikes_are_found_and_slow_heat_is_not() -> None:
    random = np.random.default_rng(1)
    slow = 20 + 30 * (1 - np.exp(-np.arange(500) / 60)) + 0.08 * random.standard_normal(500)
    assert outliers(np.arange(len(slow)), slow).size == 0
    spiked = slow.copy()
    spiked[[50, 200, 333]] += [2.0, -1.5, 3.0]
    assert list(outliers(np.arange(len(spiked)), spiked)) == [50, 200, 333]


def test_spikes_are_found_on_a_steep_course_and_at_the_ends() -> None:
    noise = np.random.default_rng(3).normal(0, 0.05, 400)
    steep = 60 * np.exp(-np.arange(400) / 60) + noise
    assert outliers(np.arange(len(steep)), steep).size == 0
    spiked = steep.copy()
    spiked[[0, 30, 399]] += [2.0, -2.0, 2.0]
    assert list(outliers(np.arange(len(spiked)), spiked)) == [0, 30, 399]
    bent = np.concatenate([np.zeros(200), np.arange(200) * 1.0]) + noise
    assert outliers(np.arange(len(bent)), bent).size == 0


def test_three_spikes_in_a_row_are_found_and_a_short_pulse_of_the_input_is_left() -> None:
    """After a leap of the input the input may have done it."""
    time = 60.0 * np.arange(400)
    readings = 320 - 20 * np.exp(-time / 6000) + np.random.default_rng(2).normal(0, 0.05, 400)
    readings[300:303] += 34.0
    readings[350] += 34.0
    assert outliers(time, readings).tolist() == [300, 301, 302, 350]
    assert outliers(time, readings, driven=np.array([300])).tolist() == [350]
    assert outliers(time, readings, driven=np.array([350])).tolist() == [300, 301, 302, 350]


def test_a_level_of_four_readings_a_step_and_a_slow_pulse_are_no_spikes() -> None:
    time = 5.0 * np.arange(300)
    noise = np.random.default_rng(4).normal(0, 0.05, 300)
    level, step, pulse = (300 + noise for _ in range(3))
    level[100:104] += 34.0
    step[100:] += 34.0
    pulse += 3 * np.clip(10 - np.abs(np.arange(300) - 100), 1, 8)
    bend = 300 + np.cumsum(np.where(np.arange(300) < 100, -0.3, 1.5)) + noise
    assert [outliers(time, each).tolist() for each in (level, step, pulse, bend)] == [[], [], [], []]


def test_scatter_is_that_of_the_rows_however_uneven_they_are() -> None:
    random = np.random.default_rng(6)
    time = np.sort(random.uniform(0, 3600, 400))
    steep = 60 * np.exp(-time / 600) + random.normal(0, 0.05, 400)
    for each in (steep, steep + 0.02 * time):
        assert abs(row_noise(time, each) / 0.05 - 1) < 0.15


def test_spikes_of_a_strangers_log_are_the_rows_that_were_spoilt() -> None:
    import pandas as pd

    log = pd.read_csv(given("logs_that_fail") / "spike.csv")
    time, wind, body = (log[name].to_numpy() for name in ("time [s]", "wind [degC]", "body [degC]"))
    assert outliers(time, body).tolist() == [300, 301, 302, 500]
    assert outliers(time, wind).tolist() == []


def test_a_peak_where_what_drives_a_machine_stops_is_no_spike() -> None:
    """Heat rises until a motor stops, and falls from that row on: one reading is the highest by far."""
    time = np.arange(0.0, 7200.0, 60.0)
    noise = np.random.default_rng(1).normal(0.0, 0.05, time.size)
    peaked = 5.0 - 0.006 * np.abs(time - 2700.0) + noise
    assert outliers(time, peaked).tolist() == [45]
    for first in (45, 46):  # the row that has the new input, or it stopped just after the row before
        assert outliers(time, peaked, driven=np.array([first])).size == 0
    for height in (2.0, -2.0):
        spiked = peaked + np.where(np.arange(time.size) == 45, height, 0.0)
        assert outliers(time, spiked, driven=np.array([45])).tolist() == [45]


def test_a_peak_between_readings_that_are_rows_apart_is_no_spike() -> None:
    """A link straightens while its motor stops for two minutes; it is read once a minute."""
    time = np.arange(0.0, 12_000.0)
    after = np.exp(-np.clip(time - 9067, 0, None) / 150)
    growth = 108.0 + 0.06 * np.clip(time - 8936, 0, 131) * after
    found = {False: 0, True: 0}
    for seed in range(60):
        noise = np.random.default_rng(seed).normal(0, 0.4, time.size)
        read = np.where(time % 60 == 0, growth + noise, np.nan)
        for spike in found:
            spiked = read + np.where((time == 6000) & spike, 8.0, 0.0)
            found[spike] += len(outliers(time, spiked, driven=np.array([8936, 9067])))
    assert found == {False: 0, True: 60}

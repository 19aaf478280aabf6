"""Rows that no machine made: nothing but zeros, and readings that leap away and back."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from warmlink.orchestration.diagnosis.data.outliers import leap
from warmlink.orchestration.diagnosis.data.rows import without_slips, zeros
from warmlink.orchestration.scenarios.logged.cells import Column
from warmlink.orchestration.scenarios.logged.layout import headings
from warmlink.orchestration.scenarios.logged.sheet import Sheet

SPEED, BASE = Column("speed", "rad/s", "motor.speed"), Column("base", "degC", "link.base_temperature")
TIME = 10.0 * np.arange(60)


def sheet() -> Sheet:
    frame = pd.DataFrame({0: TIME})
    frame.index = pd.Index(range(2, 62))
    return Sheet("log.csv", headings((["time"], ["s"])), frame, "point", False, "text")


def log() -> tuple[np.ndarray, np.ndarray]:
    warm = 295.0 + 20.0 * (1 - np.exp(-TIME / 200)) + np.random.default_rng(1).normal(0.0, 0.02, 60)
    return np.full(60, 2.0), warm


def test_a_row_of_zeros_is_one_if_a_temperature_falls_to_the_zero_of_its_unit() -> None:
    speed, base = log()
    speed[[0, 30]], base[[0, 30]] = 0.0, 273.15
    speed[40] = 0.0  # the machine stands still
    signals = [(SPEED, speed), (BASE, base)]
    assert zeros(signals, [base]).tolist() == [0, 30]
    assert zeros(signals, []).size == 0, "without a temperature nobody can tell"


def test_what_is_zero_in_half_of_the_rows_is_no_slip() -> None:
    speed, base = np.zeros(60), np.full(60, 273.15)
    base[:30] = 295.0
    assert zeros([(SPEED, speed), (BASE, base)], [base]).size == 0


def test_inputs_keep_the_value_before_and_readings_are_missing() -> None:
    speed, base = log()
    speed[20:], speed[31:] = 3.0, 4.0
    speed[[0, 30]], base[[0, 30]] = 0.0, 273.15
    base[45] += 8.0
    inputs, readings, told = without_slips(
        sheet(), TIME, [SPEED, BASE], {SPEED.variable: speed}, {BASE.variable: base}
    )
    assert inputs[SPEED.variable][[0, 1, 29, 30, 31]].tolist() == [2.0, 2.0, 3.0, 3.0, 4.0]
    assert np.flatnonzero(np.isnan(readings[BASE.variable])).tolist() == [0, 30, 45]
    assert told[0].startswith("log.csv: rows 2, 32: nothing but zeros, taken for missing values")
    assert told[1].startswith("log.csv: row 47: base leaps away and back by up to 8")
    assert " K, as no heat does" in told[1]
    assert speed[30] == 0.0, "what was given is left as it was"


def test_a_leap_is_measured_from_the_course_in_time() -> None:
    """Rows that are not evenly spaced: the course goes by their times."""
    times = np.array([0.0, 1.0, 2.0, 10.0, 11.0])
    values = 2.0 * times
    values[3] += 5.0
    assert leap(times, values, np.array([3])) == pytest.approx(5.0)


def test_noise_of_an_input_hides_no_fault() -> None:
    """A room that was logged with noise was taken to leap in every row, and no reading was looked at."""
    speed, base = log()
    base[[15, 35]] += 8.0
    room = 295.0 + np.random.default_rng(2).normal(0.0, 0.02, TIME.size)
    ambient = Column("ambient", "degC", "link.ambient_temperature")
    inputs = {SPEED.variable: speed + 0.001 * room, ambient.variable: room}
    _, readings, told = without_slips(sheet(), TIME, [SPEED, ambient, BASE], inputs, {BASE.variable: base})
    assert np.flatnonzero(np.isnan(readings[BASE.variable])).tolist() == [15, 35]
    assert len(told) == 1


def test_an_empty_cell_does_not_hide_a_row_of_zeros() -> None:
    speed, base = log()
    speed[30], base[30] = 0.0, 273.15
    never, tip = np.full(60, np.nan), base.copy()
    tip[30] = np.nan
    signals = [(SPEED, speed), (BASE, base), (BASE, never), (BASE, tip)]
    assert zeros(signals, [never, tip, base]).tolist() == [30]

"""Machines of other structure: what the bench takes for growth from the start, and how it sums up."""

import numpy as np
import pytest

from benchmarks.other_structure import LOGS, Judged, growth_error, log_of, summary
from benchmarks.strange_machine import Machine


def judged(seed: int, verdict: str, after: float) -> Judged:
    before = {"continuous": 10.0, "winter": 10.0}
    delivered, virtual = {"continuous": after, "winter": after}, {"continuous": 1.0, "winter": 1.0}
    return Judged(seed, verdict, "calibrated", before, delivered, virtual, 1.0)


def test_growth_counts_from_the_start_of_a_run() -> None:
    read = np.array([5e-6, 5e-6, 5e-6, np.nan, 9e-6, 13e-6])
    told = np.array([0.0, 0.0, 0.0, 2e-6, 4e-6, 6e-6])
    assert growth_error(read, told) == pytest.approx(np.sqrt(2**2 / 5))


def test_what_is_worse_and_what_is_named_is_counted() -> None:
    said = summary([judged(3, "unknown", 4.0), judged(4, "named", 12.0)], logs=1)
    assert "2 machines, seeds 3 to 4" in said
    assert "better than uncorrected 1, worse by more than 5 % 1" in said
    assert "median 0.80 of the duty cycles, 0.80 of machines, 0.80 without hot_workpieces" in said
    assert "as virtual measurement: median 0.100 of machines" in said
    assert "wrong names 1" in said


def test_heat_that_no_input_tells_of_is_counted_apart() -> None:
    errors = {"continuous": 3.0, "hot_workpieces": 4.0}
    one = Judged(1, "unknown", "calibrated", {"continuous": 6.0, "hot_workpieces": 8.0}, errors, errors, 1.0)
    assert one.share == pytest.approx(0.5)
    hot = Judged(1, "unknown", "calibrated", {"continuous": 6.0, "hot_workpieces": 1.0}, errors, errors, 1.0)
    assert hot.share > 0.8
    assert hot.share_of_told == pytest.approx(0.5)


def test_logs_are_those_of_the_seed_and_have_an_owners_columns() -> None:
    machine = Machine(5)
    one, same = (log_of(machine, LOGS[1], 5) for _ in range(2))
    assert one.equals(same)
    assert {"time [s]", "speed [rad/s]", "torque [N.m]", "elongation [um]"} <= set(one)
    assert one["elongation [um]"].notna().sum() > 30

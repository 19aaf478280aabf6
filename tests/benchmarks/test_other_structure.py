"""Machines of other structure: what the bench takes for growth from the start, and how it sums up."""

import numpy as np
import pytest

from benchmarks.other_structure import LOGS, Judged, growth_error, log_of, summary
from benchmarks.strange_machine import Machine


def judged(seed: int, verdict: str, after: float) -> Judged:
    before = {"continuous": 10.0, "winter": 10.0}
    return Judged(seed, verdict, "calibrated", before, {"continuous": after, "winter": after}, 0.1, 1.0)


def test_growth_counts_from_the_start_of_a_run() -> None:
    read = np.array([5e-6, 5e-6, 5e-6, np.nan, 9e-6, 13e-6])
    told = np.array([0.0, 0.0, 0.0, 2e-6, 4e-6, 6e-6])
    assert growth_error(read, told) == pytest.approx(np.sqrt(2**2 / 5))


def test_what_is_worse_and_what_is_named_is_counted() -> None:
    said = summary([judged(3, "unknown", 4.0), judged(4, "named", 12.0)], logs=1)
    assert "2 machines, seeds 3 to 4" in said
    assert "better than uncorrected 1, worse by more than 5 % 1" in said
    assert "median 0.80 of machines, 0.80 of their duty cycles" in said
    assert "wrong names 1" in said


def test_logs_are_those_of_the_seed_and_have_an_owners_columns() -> None:
    machine = Machine(5)
    one, same = (log_of(machine, LOGS[1], 5) for _ in range(2))
    assert one.equals(same)
    assert {"time [s]", "speed [rad/s]", "torque [N.m]", "elongation [um]"} <= set(one)
    assert one["elongation [um]"].notna().sum() > 30

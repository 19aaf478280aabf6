"""Readings of a neighbour, made fit to be an input."""

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.arm.measured import over_steps, smoothed

TIME = np.arange(0.0, 1800.0, 10.0)


def test_a_line_stays_what_it_is() -> None:
    line = 300.0 + 0.01 * TIME
    assert smoothed(TIME, line, np.array([])) == pytest.approx(line, abs=1e-9)


def test_most_of_the_noise_goes() -> None:
    """A line through 13 readings leaves 1 / sqrt(13) of it at its middle."""
    random, middle = np.random.default_rng(1), TIME.size // 2
    left = [
        smoothed(TIME, random.normal(300.0, 0.08, TIME.size), np.array([]))[middle] - 300.0 for _ in range(60)
    ]
    assert np.std(left) == pytest.approx(0.08 / np.sqrt(13), rel=0.3)


def test_a_kink_where_the_duty_changes_is_kept() -> None:
    course = 300.0 + 0.02 * np.minimum(TIME, 900.0)
    assert smoothed(TIME, course, np.array([900.0])) == pytest.approx(course, abs=1e-9)
    rounded = smoothed(TIME, course, np.array([]))
    assert np.abs(rounded - course).max() > 0.1


def test_changes_in_quick_succession_end_no_line() -> None:
    course = 300.0 + np.random.default_rng(2).normal(0.0, 0.08, TIME.size)
    quick = np.arange(20.0, 1780.0, 20.0)
    assert smoothed(TIME, course, quick) == pytest.approx(smoothed(TIME, course, np.array([])))


def test_a_held_row_has_the_mean_to_the_next() -> None:
    assert over_steps(np.array([1.0, 2.0, 4.0])).tolist() == [1.5, 3.0, 4.0]

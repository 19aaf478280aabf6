"""What a sensor would have read at the start: heating may begin with the first row, or not at all."""

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.data.start import at_start

NOISE, ROOM = 0.05, 295.15

COURSES = {
    "at rest": lambda t: 0 * t,
    "a slow rise": lambda t: 0.003 * t,
    "heated at once": lambda t: 10 * -np.expm1(-t / 30),
    "heated after half a minute": lambda t: np.where(t > 32, 10 * -np.expm1(-(t - 32) / 30), 0.0),
}


@pytest.mark.parametrize("interval", [1.0, 5.0, 20.0, 60.0])
@pytest.mark.parametrize("name", COURSES)
def test_the_start_is_found_to_within_a_few_times_the_noise(name: str, interval: float) -> None:
    """The mean of the first minute lay 5.7 K too high where heating began at once, and its line 1.2 K."""
    time = np.arange(0.0, 3600.0, interval)
    random = np.random.default_rng(int(interval))
    found = [
        at_start(time, ROOM + COURSES[name](time) + random.normal(0, NOISE, time.size)) for _ in range(20)
    ]
    errors = np.array(found) - ROOM
    assert np.sqrt(np.mean(errors**2)) < 3 * NOISE


def test_a_spike_after_the_first_rows_and_empty_cells_change_nothing_much() -> None:
    time = np.arange(0.0, 600.0, 5.0)
    values = ROOM + np.random.default_rng(1).normal(0, NOISE, time.size)
    values[[6, 8]] = ROOM + 34, np.nan
    assert at_start(time, values) == pytest.approx(ROOM, abs=2 * NOISE)


def test_no_reading_in_the_first_minute_says_nothing() -> None:
    time = np.arange(0.0, 600.0, 5.0)
    assert at_start(time, np.where(time > 60, ROOM, np.nan)) is None


def test_nothing_but_zeros_starts_at_zero() -> None:
    assert at_start(np.arange(0.0, 100.0, 10.0), np.zeros(10)) == 0.0

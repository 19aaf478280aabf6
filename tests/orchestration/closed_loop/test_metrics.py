import numpy as np
import pytest

from warmlink.orchestration.closed_loop.metrics import (
    conduct,
    error_metrics,
    reduction_percent,
    shown_percent,
    warm_up_first,
)

TOLERANCE = 5e-6


def test_figures_of_a_ramp() -> None:
    time = np.linspace(0.0, 100.0, 101)
    metrics = error_metrics(time, 1e-6 * time / 10, TOLERANCE)
    assert metrics.max_abs_um == pytest.approx(10)
    assert metrics.rms_um == pytest.approx(10 / np.sqrt(3), rel=1e-4)
    assert metrics.p95_abs_um == pytest.approx(9.5)
    assert metrics.time_to_tolerance_s is None


def test_time_to_tolerance_is_the_first_time_after_which_the_error_stays_inside() -> None:
    time = np.arange(6.0)
    back_and_forth = 1e-6 * np.array([9.0, -4.0, -6.0, 4.9, 5.0, -5.0])
    assert error_metrics(time, back_and_forth, TOLERANCE).time_to_tolerance_s == 3.0
    assert error_metrics(time, 0.5 * back_and_forth, TOLERANCE).time_to_tolerance_s == 0.0


def test_an_error_that_is_not_a_number_is_never_within_tolerance() -> None:
    metrics = error_metrics(np.arange(100.0), np.array([*[0.0] * 99, np.nan]), TOLERANCE)
    assert metrics.time_to_tolerance_s is None
    assert np.isnan([metrics.max_abs_um, metrics.p95_abs_um, metrics.rms_um]).all()


def test_root_mean_square_weighs_by_time_not_by_points() -> None:
    time = np.array([0.0, 1.0, 2.0, 3.0, 103.0])
    error = np.full(5, 2e-6)
    assert error_metrics(time, error, TOLERANCE).rms_um == pytest.approx(2)


def test_reduction_counts_the_largest_error() -> None:
    time = np.arange(3.0)
    before = error_metrics(time, np.array([0.0, 20e-6, 80e-6]), TOLERANCE)
    after = error_metrics(time, np.array([0.0, 8e-6, -4e-6]), TOLERANCE)
    assert reduction_percent(before, after) == pytest.approx(90)
    assert reduction_percent(error_metrics(time, np.zeros(3), TOLERANCE), after) is None


@pytest.mark.parametrize("tolerance", [TOLERANCE, 10e-6])
def test_an_error_that_dies_out_is_within_tolerance_when_the_exponential_says_so(tolerance: float) -> None:
    """A exp(-t / T) passes the tolerance at T ln(A / tolerance): 1 % of it is worth 10 of these seconds."""
    time, largest, constant = np.arange(0.0, 6000.0), 80e-6, 1000.0
    settled = error_metrics(time, largest * np.exp(-time / constant), tolerance).time_to_tolerance_s
    assert settled == np.ceil(constant * np.log(largest / tolerance))


def test_an_error_of_exactly_the_tolerance_is_within_it_and_the_next_larger_number_is_not() -> None:
    time = np.arange(3.0)
    assert error_metrics(time, np.full(3, -TOLERANCE), TOLERANCE).time_to_tolerance_s == 0
    beyond = np.array([np.nextafter(TOLERANCE, 1.0), TOLERANCE, TOLERANCE])
    assert error_metrics(time, beyond, TOLERANCE).time_to_tolerance_s == 1


def test_conduct_counts_time_ready_travel_and_leaps() -> None:
    time = np.array([0.0, 10.0, 20.0, 30.0, 70.0])
    error = 1e-6 * np.array([1.0, 9.0, 1.0, 1.0, 0.0])
    first, second = np.array([1.0, 1, 1, 0, 0]), np.array([1.0, 1, 0, 0, 1])
    corrections = 1e-6 * np.array([0.0, 3, -1, 0, 0]), 1e-6 * np.array([0.0, 1, 2, 3, 4])
    found = conduct(time, error, (first, second), corrections, TOLERANCE)
    assert found.ready_percent == pytest.approx(100 * 20 / 70)
    assert found.ready_wrong_percent == pytest.approx(50)
    assert found.fine_not_ready_percent == pytest.approx(100 * 50 / 60)
    assert found.travel_um_h == pytest.approx(8 * 3600 / 70)
    assert found.leap_um == pytest.approx(4)
    never = conduct(time, error, (0 * first,), corrections, TOLERANCE)
    assert (never.ready_percent, never.ready_wrong_percent) == (0.0, 0.0)
    nobody = conduct(time, error, (), corrections, TOLERANCE)
    assert np.isnan([nobody.ready_percent, nobody.ready_wrong_percent, nobody.fine_not_ready_percent]).all()
    assert nobody.leap_um == found.leap_um


def test_what_is_nearly_all_is_not_shown_as_all() -> None:
    shares = {97.0: "97 %", 99.4: "99 %", 99.6: "99.6 %", 99.996: "99.9 %", 100.0: "100 %", 165.3: "165 %"}
    assert {share: shown_percent(share) for share in shares} == shares
    assert shown_percent(-3.2) == "-3 %"


def test_warming_up_first_gives_what_is_left_after_the_growth_has_settled() -> None:
    time = np.arange(0, 7201.0)
    growth = 50e-6 * (1 - np.exp(-time / 1000))
    # Zero set at t, the rest grows by 50 um exp(-t/1000), which is 5 um from 1000 s ln 10 = 2303 s on.
    assert warm_up_first(time, growth, 5e-6) == pytest.approx((7200 - 1000 * np.log(10)) / 60, abs=1.0)


def test_warming_up_first_gives_everything_where_nothing_grows() -> None:
    time = np.arange(0, 601.0)
    assert warm_up_first(time, np.zeros(601), 5e-6) == 10.0


def test_minutes_between_two_levels_count_once() -> None:
    time = np.arange(0, 3601.0)
    growth = np.where((time // 600) % 2 == 0, 0.0, 30e-6)
    # Half of the hour is at either level, and a zero set at once makes use of one of them.
    assert warm_up_first(time, growth, 5e-6) == pytest.approx(30, abs=0.5)


@pytest.mark.parametrize("step", [1.0, 20.0, 60.0])
def test_the_end_of_a_warm_up_is_sought_on_a_grid_of_a_minute_whatever_the_step(step: float) -> None:
    time = np.arange(0, 7201.0, step)
    growth = np.where(time < 60.0, 0.0, np.where(time < 1020.0, 30e-6, 60e-6))
    assert warm_up_first(time, growth, 5e-6) == 103.0  # from 1020 s on, which is the 17th minute

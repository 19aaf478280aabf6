"""Closed forms against independent evaluation: quadrature, series, limits."""

import numpy as np
import pytest
from scipy.integrate import quad

from tests import closed_forms
from warmlink.orchestration.paper.data import GEOMETRY, MATERIALS

LINK = MATERIALS["link"]
SPAN = GEOMETRY.span
DIFFUSIVITY, EXPANSION = LINK.diffusivity, LINK.expansion_coefficient


@pytest.mark.parametrize("time", [10.0, 900.0, 3600.0])
def test_corrected_elongation_is_the_integral_of_the_semi_infinite_profile(time: float) -> None:
    integral, _ = quad(lambda x: float(closed_forms.semi_infinite_rise(x, time, 14.0, DIFFUSIVITY)), 0, SPAN)
    ours = closed_forms.corrected_eq4(time, SPAN, 14.0, EXPANSION, DIFFUSIVITY)
    assert ours == pytest.approx(EXPANSION * integral, rel=1e-9)


def test_corrected_elongation_grows_from_zero_to_the_whole_rise() -> None:
    times = np.geomspace(1e-6, 1e10, 200)
    elongation = closed_forms.corrected_eq4(times, SPAN, 14.0, EXPANSION, DIFFUSIVITY)
    assert np.all(np.diff(elongation) > 0)
    assert elongation[0] < 1e-3 * elongation[-1]
    assert elongation[-1] == pytest.approx(EXPANSION * SPAN * 14.0, rel=1e-3)


def test_printed_equation_shrinks_with_time() -> None:
    """86.9 um at 900 s and 57.0 um at 3600 s; with the factor 1/2 it meets Table II near 3100 s."""
    printed = closed_forms.printed_eq4([900.0, 3600.0], SPAN, 14.0, EXPANSION, DIFFUSIVITY) * 1e6
    np.testing.assert_allclose(printed, [86.9, 57.0], atol=0.05)
    times = np.arange(60.0, 3601.0)
    halved = closed_forms.halved_eq4(times, SPAN, 14.0, EXPANSION, DIFFUSIVITY) * 1e6
    assert np.all(np.diff(halved) < 0)
    assert abs(times[np.argmin(np.abs(halved - 33.2))] - 3100) < 100


def test_fin_elongation_and_heat_flow_follow_from_its_profile() -> None:
    m, biot, length = 4.3, 0.006, 0.3
    section, k = 1.6e-4, 167.0
    profile = lambda x: float(closed_forms.fin_rise(x, length, 14.0, m, biot))  # noqa: E731
    integral, _ = quad(profile, 0, SPAN)
    assert closed_forms.fin_elongation(SPAN, length, 14.0, m, EXPANSION, biot) == pytest.approx(
        EXPANSION * integral
    )
    whole, _ = quad(profile, 0, length)
    lost = k * section * m * (m * whole + biot * profile(length))
    assert closed_forms.fin_heat_flow(length, 14.0, m, k, section, biot) == pytest.approx(lost)


def test_series_and_semi_infinite_solid_agree_while_the_far_end_is_cold() -> None:
    x = np.linspace(0, 0.1, 11)
    series = closed_forms.bar_fourier_rise(x, 60.0, 0.33, 14.0, DIFFUSIVITY)
    np.testing.assert_allclose(series, closed_forms.semi_infinite_rise(x, 60.0, 14.0, DIFFUSIVITY), atol=1e-3)


def test_a_bar_that_is_hot_enough_for_long_enough_is_hot_throughout() -> None:
    np.testing.assert_allclose(closed_forms.bar_fourier_rise([0.0, 0.3], 1e5, 0.33, 14.0, DIFFUSIVITY), 14.0)

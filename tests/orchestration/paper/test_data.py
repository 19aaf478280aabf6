"""The paper's numbers as data."""

import pytest

from warmlink.orchestration.paper.data import GEOMETRY, PAPER


def test_geometry_agrees_with_the_inches_of_the_paper() -> None:
    g = GEOMETRY
    inch = 0.0254
    assert (g.length, g.width, g.thickness) == pytest.approx((13 * inch, 1 * inch, 0.25 * inch))
    assert g.length - g.diode_centre == pytest.approx(0.52 * inch)
    assert g.span == pytest.approx(0.2916, abs=5e-5)


def test_every_assumed_length_is_a_length() -> None:
    g = GEOMETRY
    assert all(getattr(g, name) > 0 for name in g.assumed)


def test_printed_differences_follow_from_the_printed_deformations() -> None:
    for case, slack in (("stationary", 0.15), ("moving", 0.05)):
        n = {key: entry.value for key, entry in PAPER[case].items()}
        percent = 100 * abs(n["elongation_predicted"] / n["elongation_measured"] - 1)
        assert percent == pytest.approx(n["difference"], abs=slack + 0.05)

from __future__ import annotations

import pytest

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.component.units import display_conversion, unit


@pytest.mark.parametrize(
    ("text", "exponents"),
    [
        ("1", {}),
        ("W", {"kg": 1, "m": 2, "s": -3}),
        ("W/(m2.K)", {"kg": 1, "s": -3, "K": -1}),
        ("W.s2/rad2", {"kg": 1, "m": 2, "s": -1, "rad": -2}),
        ("N.m/A", {"kg": 1, "m": 2, "s": -2, "A": -1}),
        ("J/(kg.K)", {"m": 2, "s": -2, "K": -1}),
        ("Ohm", {"kg": 1, "m": 2, "s": -3, "A": -2}),
        ("m-1", {"m": -1}),
    ],
)
def test_exponents(text: str, exponents: dict[str, int]) -> None:
    assert unit(text).exponents == exponents
    assert unit(text).factor == 1


@pytest.mark.parametrize(
    ("stored", "shown", "value", "reading"),
    [
        ("K", "degC", 295.15, 22.0),
        ("m", "um", 35e-6, 35.0),
        ("m", "mm", 0.3302, 330.2),
        ("m2", "mm2", 1.6129e-4, 161.29),
        ("K/s", "K/h", 1 / 3600, 1.0),
        ("m/K", "µm/K", 23.6e-6, 23.6),
        ("rad", "deg", 3.141592653589793, 180.0),
    ],
)
def test_display(stored: str, shown: str, value: float, reading: float) -> None:
    factor, offset = display_conversion(stored, shown)
    assert factor * value + offset == pytest.approx(reading, rel=1e-12)


@pytest.mark.parametrize("text", ["W/m2/K", "furlong", "W/m2.K", "", "degC/s", "W m", "10", "m/10", "m0"])
def test_what_is_no_unit_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="unit"):
        unit(text)


def test_a_display_of_another_kind_is_refused() -> None:
    with pytest.raises(ValueError, match="cannot be displayed"):
        display_conversion("K", "um")


def test_every_unit_in_use_is_understood() -> None:
    for entry in catalogue():
        for scalar in entry.component.scalars():
            unit(scalar.variable.unit)
            if scalar.variable.display is not None:
                display_conversion(scalar.variable.unit, scalar.variable.display)

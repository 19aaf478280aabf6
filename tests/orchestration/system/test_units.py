"""Units: by definition, by name, and between each other."""

from __future__ import annotations

import math
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system import units
from warmlink.orchestration.system.units import (
    BASE_UNITS,
    QuantityError,
    Unit,
    conversion,
    parse_unit,
    read_unit,
    spelled,
)
from warmlink.orchestration.system.xml import parse_xml


def exponents(**powers: int) -> tuple[int, ...]:
    return tuple(powers.get(name, 0) for name in BASE_UNITS)


@pytest.mark.parametrize(
    ("name", "powers", "factor", "offset"),
    [
        ("W", {"kg": 1, "m": 2, "s": -3}, 1.0, 0.0),
        ("W/(m.K)", {"kg": 1, "m": 1, "s": -3, "K": -1}, 1.0, 0.0),
        ("W/(m2.K)", {"kg": 1, "s": -3, "K": -1}, 1.0, 0.0),
        ("W/(m**2*K)", {"kg": 1, "s": -3, "K": -1}, 1.0, 0.0),
        ("W.s/(m3.K)", {"kg": 1, "m": -1, "s": -2, "K": -1}, 1.0, 0.0),
        ("W.s2/rad2", {"kg": 1, "m": 2, "s": -1, "rad": -2}, 1.0, 0.0),
        ("J/(kg.K)", {"m": 2, "s": -2, "K": -1}, 1.0, 0.0),
        ("kg.m-3", {"kg": 1, "m": -3}, 1.0, 0.0),
        ("rad/s", {"rad": 1, "s": -1}, 1.0, 0.0),
        ("N.m", {"kg": 1, "m": 2, "s": -2}, 1.0, 0.0),
        ("N.m.s/rad", {"kg": 1, "m": 2, "s": -1, "rad": -1}, 1.0, 0.0),
        ("N.m/A", {"kg": 1, "m": 2, "s": -2, "A": -1}, 1.0, 0.0),
        ("Ohm", {"kg": 1, "m": 2, "s": -3, "A": -2}, 1.0, 0.0),
        ("1/K", {"K": -1}, 1.0, 0.0),
        ("degC", {"K": 1}, 1.0, 273.15),
        ("degF", {"K": 1}, 5 / 9, 459.67 * 5 / 9),
        ("um", {"m": 1}, 1e-6, 0.0),
        ("µm", {"m": 1}, 1e-6, 0.0),
        ("deg", {"rad": 1}, math.pi / 180, 0.0),
        ("rpm", {"rad": 1, "s": -1}, math.pi / 30, 0.0),
        ("degrees", {"rad": 1}, math.pi / 180, 0.0),
        ("radian/s", {"rad": 1, "s": -1}, 1.0, 0.0),
        ("revolutions/min", {"rad": 1, "s": -1}, math.pi / 30, 0.0),
        ("rev/min", {"rad": 1, "s": -1}, math.pi / 30, 0.0),
        ("K/h", {"K": 1, "s": -1}, 1 / 3600, 0.0),
        ("m.m/(s.s)", {"m": 2, "s": -2}, 1.0, 0.0),
        ("(m/s)**2", {"m": 2, "s": -2}, 1.0, 0.0),
        ("%", {}, 0.01, 0.0),
        ("m s", {"m": 1, "s": 1}, 1.0, 0.0),
        ("kg/(m s)", {"kg": 1, "m": -1, "s": -1}, 1.0, 0.0),
        ("m Pa", {"kg": 1, "s": -2}, 1.0, 0.0),
        ("W / ( m2 . K )", {"kg": 1, "s": -3, "K": -1}, 1.0, 0.0),
        ("J ** 2 / (kg  K)", {"kg": 1, "m": 4, "s": -4, "K": -1}, 1.0, 0.0),
        ("1", {}, 1.0, 0.0),
        ("", {}, 1.0, 0.0),
    ],
)
def test_names_in_modelicas_and_pints_notation(
    name: str, powers: dict[str, int], factor: float, offset: float
) -> None:
    unit = parse_unit(name)
    assert unit.exponents == exponents(**powers)
    assert unit.factor == pytest.approx(factor, rel=1e-14)
    assert unit.offset == pytest.approx(offset, rel=1e-14)


@pytest.mark.parametrize(
    "name",
    [
        "blorks",
        "3 m",
        "__import__('os')",
        "W/",
        "m**999",
        "m**0.5",
        "x" * 1000,
        "9**9**9**9",
        "m**((9))**9",
        "m**9**9",
    ],
)
def test_what_is_no_unit_is_named(name: str) -> None:
    with pytest.raises(InputError, match="is not a"):
        parse_unit(name)


@settings(max_examples=50)
@given(st.text(max_size=12))
def test_any_text_is_a_unit_or_named(name: str) -> None:
    try:
        unit = parse_unit(name)
    except InputError:
        return
    assert math.isfinite(unit.factor)


def test_a_temperature_has_a_zero_and_a_difference_has_none() -> None:
    celsius, kelvin = Unit("degC"), Unit("K")
    assert conversion(celsius, kelvin)(20.0) == pytest.approx(293.15, rel=1e-15)
    assert conversion(kelvin, celsius)(293.15) == pytest.approx(20.0, rel=1e-14)
    assert conversion(celsius, kelvin, difference=True)(20.0) == 20.0


def test_equal_units_convert_exactly_even_if_nobody_knows_them() -> None:
    assert conversion(Unit("furlong?"), Unit("furlong?")).identity
    assert conversion(Unit("K", exponents(K=1)), Unit("kelvin", exponents(K=1))).identity


@pytest.mark.parametrize("written", ["degC", "deg C", "Deg C", "degree C", "degrees C", "° C", "°C", "C"])
def test_a_temperature_is_read_however_its_degree_is_written(written: str) -> None:
    """22 degrees C were 0.38 K: degrees, times a degree Celsius."""
    assert conversion(parse_unit(spelled(written, "K")), Unit("K"))(22.0) == pytest.approx(295.15)


def test_definitions_count_more_than_names() -> None:
    strange = Unit("m", exponents(m=1), 1000.0)
    assert conversion(strange, Unit("m", exponents(m=1)))(1.0) == 1000.0


def test_different_quantities_do_not_convert() -> None:
    with pytest.raises(QuantityError, match=r"^W does not convert to K$"):
        conversion(Unit("W"), Unit("K"))
    with pytest.raises(QuantityError):
        conversion(Unit("rad/s"), Unit("1/s"))


@given(
    st.floats(1e-6, 1e6),
    st.floats(-500, 500),
    st.floats(1e-6, 1e6),
    st.floats(-500, 500),
    st.floats(-1e3, 1e3),
)
def test_there_and_back_is_where_it_was(f: float, o: float, g: float, q: float, x: float) -> None:
    one, two = Unit("a", exponents(K=1), f, o), Unit("b", exponents(K=1), g, q)
    there = conversion(one, two)(x)
    scale = 1e-9 + abs(x) + (abs(o) + abs(q)) / f
    assert conversion(two, one)(there) == pytest.approx(x, abs=1e-12 * scale)


def test_a_unit_is_read_with_its_definition() -> None:
    text = b'<Unit name="mm2"><BaseUnit m="2" factor="1e-6"/><DisplayUnit name="m2" factor="1e-6"/></Unit>'
    assert read_unit(parse_xml(text, "x"), "x") == Unit("mm2", exponents(m=2), 1e-6)
    assert read_unit(parse_xml(b'<Unit name="K"/>', "x"), "x") == Unit("K")


@pytest.mark.parametrize("attributes", ['factor="0"', 'm="one"', 'factor="inf"', 'offset="x"', 'm="1e99"'])
def test_a_bad_definition_is_named(attributes: str) -> None:
    with pytest.raises(InputError, match="x: unit u"):
        read_unit(parse_xml(f'<Unit name="u"><BaseUnit {attributes}/></Unit>'.encode(), "x"), "x")


@pytest.mark.parametrize(
    "name", ["h999999999999999999999", "h99", "um-99", "h.h99999999999", "W/h9999999999"]
)
def test_a_power_that_no_number_holds_is_refused_at_once(name: str) -> None:
    """`h99` ended in an OverflowError, and the first never ended."""
    began = time.process_time()
    with pytest.raises(InputError, match="is not a"):
        parse_unit(name)
    assert time.process_time() - began < 8.0  # the first unit of all loads a library


def test_what_pint_was_asked_once_is_remembered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """To import pint took a quarter of a short run."""
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path))
    parse_unit.cache_clear()
    before = parse_unit("mNm")
    parse_unit.cache_clear()
    monkeypatch.setattr(units, "_registry", lambda: pytest.fail("pint is asked again"))
    assert parse_unit("mNm") == before
    parse_unit.cache_clear()

"""Terms: heat by an expression, in every arithmetic; what is none is refused in a sentence."""

import math

import numpy as np
import pytest

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.errors import InputError
from warmlink.fmus.heat_term.component import HeatTerm, heat_term, read_stored, stored
from warmlink.fmus.heat_term.dimension import refuse_other_than_heat
from warmlink.fmus.heat_term.law import HeatLaw

SPEED = {"speed": "rad/s"}


def heat_of(law: str, inputs: dict[str, float], time: float = 0.0, **parameters: float) -> float:
    units = {name: "K" if name.endswith("temperature") else "rad/s" for name in inputs}
    term = HeatTerm("Tried", law, units, {name: (value, "1") for name, value in parameters.items()})
    instance = Instance(heat_term(term))
    instance.set({"to_heat_flow": 2.0, **inputs})
    instance.initialize()
    for k in range(round(time)):
        instance.step(float(k), 1.0)
    assert instance.get("total_to_heat_flow") == pytest.approx(2.0 + instance.get("heat"), abs=1e-12)
    return float(instance.get("heat"))


@pytest.mark.parametrize(
    ("law", "speed", "heat"),
    [
        ("a * max(speed - 1, 0)**1.5", 3.0, 2 * 2**1.5),
        ("a * (speed - 1)**1.5", 0.5, 0.0),
        ("a * step(speed - 1)", 1.5, 2.0),
        ("a * step(speed - 1)", 0.5, 0.0),
        ("a * sign(speed) * abs(speed)", -2.0, -4.0),
        ("a * min(speed, 1)", 4.0, 2.0),
        ("sqrt(a * speed) - exp(0)", 8.0, 3.0),
        ("a * 10**2 - -speed", 1.0, 201.0),
    ],
)
def test_a_law_says_its_heat(law: str, speed: float, heat: float) -> None:
    assert heat_of(law, {"speed": speed}, a=2.0) == pytest.approx(heat, rel=1e-14)


def test_a_lag_follows_from_rest_as_the_readme_says() -> None:
    found = heat_of("a * lag(speed, tau)", {"speed": 2.0}, time=300, a=0.5, tau=100.0)
    assert found == pytest.approx(1.0 * -math.expm1(-3.0), rel=1e-5)


def test_lags_may_stand_inside_lags() -> None:
    found = heat_of("lag(lag(speed, 50), 50)", {"speed": 2.0}, time=200)
    assert found == pytest.approx(2 * (1 - 5 * math.exp(-4)), rel=1e-4)


def test_derivatives_pass_where_a_power_begins() -> None:
    law = HeatLaw("a * max(speed - b, 0)**n")
    for speed in (0.5, 1.0):  # at the corner, log(0) would stand in the derivative by n

        def heat(n: complex, speed: float = speed) -> complex:
            return complex(law.heat({"a": 1.0, "b": 1.0, "n": n, "speed": speed}.__getitem__, (), 0.0))

        assert heat(1.5 + 1e-20j).imag == 0.0
    import casadi as ca

    n = ca.SX.sym("n")
    symbols = law.heat({"a": 1.0, "b": 1.0, "n": n, "speed": ca.SX(1.0)}.__getitem__, (), 0.0)
    assert float(ca.Function("f", [n], [ca.jacobian(symbols, n)])(1.5)) == 0.0


@pytest.mark.parametrize(
    "law",
    [
        "speed**b",
        "speed**2",
        "speed**-2",
        "(-speed)**0.5",
        "speed**speed",
        "2**speed",
        "sign(speed - 2) * speed**3",
    ],
)
def test_numbers_and_symbols_say_the_same(law: str) -> None:
    import casadi as ca

    read, speed = HeatLaw(law), ca.SX.sym("speed")
    symbols = read.heat({"speed": speed, "b": ca.SX(2.0)}.__getitem__, (), 0.0)
    function = ca.Function("heat", [speed], [symbols])
    for value in (-2.0, 0.5, 2.0, 3.0):
        numbers = read.heat({"speed": value, "b": 2.0}.__getitem__, (), 0.0)
        assert float(function(value)) == pytest.approx(numbers, rel=1e-14)


@pytest.mark.parametrize(
    "text",
    [
        "a *",
        "__import__('os').remove('x')",
        "speed.__class__()",
        "a if speed else 0",
        "(lambda: 1)()",
        "lag(speed)",
        "root(speed)",
        "speed > 1",
        "'3'",
        "True",
        "1/0 + speed",
        "9**9**9**9 * speed",
        "speed + " * 100 + "speed",
        "",
    ],
)
def test_what_is_no_law_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="heat: "):
        HeatLaw(text)


@pytest.mark.parametrize(
    ("law", "a", "said"),
    [
        ("a * speed", "W", "is in kg.m2.s-4, and heat is in W"),
        ("a * speed**1.5", "W", "heat is in W"),
        ("a + speed", "W", "mixes units: kg.m2.s-3 and s-1"),
        ("a * lag(speed, a)", "W.s/rad", "time constant of a lag"),
        ("a * exp(speed)", "W", "mixes units: s-1 and a plain number"),
        ("a * speed**(a/a)", "W", "no number"),
    ],
)
def test_a_law_of_another_unit_than_heat_is_refused(law: str, a: str, said: str) -> None:
    with pytest.raises(InputError) as refused:
        refuse_other_than_heat(HeatLaw(law), {**SPEED, "a": a})
    assert said in str(refused.value)


@pytest.mark.parametrize(
    "law",
    ["a * speed / b", "a * (speed / b)**1.5", "a * lag(speed / b, 60)", "3 * speed", "a * step(speed - 1)"],
)
def test_a_law_of_heat_may_leave_numbers_bare(law: str) -> None:
    refuse_other_than_heat(HeatLaw(law), {**SPEED, "a": "W", "b": "rad/s"})


@pytest.mark.parametrize("law", ["a * heat", "a * lagged", "b * speed"])
def test_names_of_the_component_s_own_and_unknown_ones_are_refused(law: str) -> None:
    with pytest.raises(InputError, match=r"Tried\.heat"):
        heat_term(HeatTerm("Tried", law, {**SPEED, "heat": "W", "lagged": "1"}, {"a": (1.0, "1")}))


def test_a_term_is_read_as_it_was_stored() -> None:
    term = HeatTerm("Tried", "a * link.x[2]", {"link.x[2]": "K"}, {"a": (2.0, "W/K")})
    assert read_stored(stored(term)) == term
    component = heat_term(term)
    assert [each.name for each in component.inputs] == ["to_heat_flow", "link_x_2"]
    assert np.isclose(Instance(component).component.start_values()[0], 2.0).all()

"""What holds for every component, whichever they are: one equation for all forms, and complete state."""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import cache, partial
from typing import Any

import casadi
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from warmlink.fmus.component import Component, Derived, Input, Parameter, Scalar, State, limits
from warmlink.fmus.component.instance import Instance, Snapshot
from warmlink.fmus.component.integrator import ComplexStepJacobian
from warmlink.fmus.component.variables import Variable
from warmlink.orchestration.catalogue import components

ALL = components()
CONTINUOUS = [name for name, each in ALL.items() if each.rates is not None]


def some_input(scalar: Scalar, rng: np.random.Generator, nan: bool = True) -> float:
    """A value that an input may have."""
    variable = scalar.variable
    assert isinstance(variable, Input)
    if variable.accepts_nan and nan and rng.random() < 0.2:
        return math.nan
    if variable.type != "Real":
        top = 1 if variable.type == "Boolean" else (variable.maximum or 3)
        return float(rng.integers(0, int(top) + 1))
    scale = 10.0 if variable.unit == "K" else (variable.nominal or 1.0)
    low = -math.inf if variable.minimum is None else variable.minimum
    high = math.inf if variable.maximum is None else variable.maximum
    return float(np.clip(variable.start + scale * rng.normal(), low, high))


def some_parameter(scalar: Scalar, rng: np.random.Generator) -> float:
    """A value that a parameter may have: near the declared one, or on where it is off by default."""
    variable, start = scalar.variable, scalar.start
    assert isinstance(variable, Parameter)
    assert start is not None
    if variable.type != "Real":
        top = 1 if variable.type == "Boolean" else variable.maximum
        return float(rng.integers(0, int(top) + 1)) if top is not None else float(rng.integers(0, 1000))
    if start == 0:
        if rng.random() < 0.5:
            return 0.0
        return float(abs(variable.nominal or 0.1) * min(rng.random(), (variable.maximum or 1.0)))
    return float(start * rng.uniform(0.99, 1.01)) if start > 0 else start


def varied(component: Component, rng: np.random.Generator) -> Instance:
    """An instance with parameters at random, in so far as they are allowed, and inputs at random."""
    scalars = list(component.scalars())[: component.p.size]
    instance = Instance(component)
    set_as_far_as_allowed(instance, {scalar.name: some_parameter(scalar, rng) for scalar in scalars})
    feed(instance, rng)
    return instance


def set_as_far_as_allowed(instance: Instance, values: dict[str, float]) -> None:
    """Set parameters, leaving out single ones that are refused beside the others."""
    component = instance.component
    before = {name: instance.get(name) for name in values}
    instance.set(values)
    if any(limits.problems(component, "x", [instance.get(n) for n in component.p.names])):
        instance.set(before)
        if len(values) > 1:
            names = list(values)
            half = len(names) // 2
            for part in (names[:half], names[half:]):
                set_as_far_as_allowed(instance, {name: values[name] for name in part})


def feed(instance: Instance, rng: np.random.Generator, nan: bool = True) -> None:
    c = instance.component
    scalars = list(c.scalars())[c.p.size : c.p.size + c.u.size]
    instance.set({scalar.name: some_input(scalar, rng, nan) for scalar in scalars})


def some_step(rng: np.random.Generator) -> float:
    # Long ones seldom: a law takes a sample in each second of them.
    return float(rng.choice([0.01, 0.3, 1.0, 7.7, 31.0], p=[0.27, 0.27, 0.27, 0.14, 0.05]))


@pytest.mark.parametrize("name", ALL)
@settings(max_examples=4, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_what_follows_a_restored_state_is_bit_for_bit_what_followed_then(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    instance = varied(ALL[name], rng)
    instance.begin(float(rng.choice([0.0, 100.0])))
    instance.initialize()
    for _ in range(rng.integers(0, 6)):
        feed(instance, rng)
        instance.step(instance.time, some_step(rng))
    written = json.dumps(asdict(instance.snapshot()))
    follow = int(rng.integers(10**9))

    def onwards(each: Instance) -> list[np.ndarray]:
        duty = np.random.default_rng(follow)
        rows = [each.outputs().copy()]
        for _ in range(6):
            feed(each, duty)
            each.step(each.time, some_step(duty))
            rows += [each.outputs().copy(), np.array(each.snapshot().states)]
        return rows

    first = onwards(instance)
    instance.restore(Snapshot(**json.loads(written)))
    again = onwards(instance)
    other = Instance(ALL[name])
    other.restore(Snapshot(**json.loads(written)))
    elsewhere = onwards(other)
    for rows in (again, elsewhere):
        assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(first, rows, strict=True))


@cache
def in_casadi(name: str) -> dict[str, casadi.Function]:
    """The functions of a component, written in CasADi."""
    c = ALL[name]
    x, u = casadi.SX.sym("x", c.x.size), casadi.SX.sym("u", c.u.size)
    p, d = casadi.SX.sym("p", c.p.size), casadi.SX.sym("d", c.d.size)
    time, step = casadi.SX.sym("time"), casadi.SX.sym("step")
    found = {
        "settled": casadi.Function("settled", [p], [c.settled(p)]),
        "outputs": casadi.Function("outputs", [x, u, d, time], [c.outputs_of(x, u, d, time)]),
    }
    if c.states:
        found["begin"] = casadi.Function("begin", [u, d], [c.states_at_start(u, d)])
    if c.sampled:
        found["update"] = casadi.Function("update", [x, u, d, time, step], [c.updated(x, u, d, time, step)])
    if c.rates is not None:
        rates = c.rates_of(x, u, d, time)
        jacobians = [casadi.jacobian(rates, x), casadi.jacobian(rates, u)]
        found["rates"] = casadi.Function("rates", [x, u, d, time], [rates, *jacobians])
    return found


SIZES = {"m": 5e-5, "m/K": 1e-5}
"""Sizes of ordinary values by unit, where they are not about 1: growth is tens of micrometres."""


def sizes(declared: Sequence[State | Derived | Variable]) -> np.ndarray:
    return np.array([SIZES.get(each.unit, 1.0) for each in declared for _ in each.scalar_names])


def same(
    casadis: casadi.Function,
    ours: Callable[..., object],
    arguments: tuple[Any, ...],
    size: np.ndarray,
    rng: np.random.Generator,
) -> np.ndarray:
    """Values of our function; CasADi's equal them but for 1e-12 of their size and the arguments' rounding."""

    def with_changed(place: int, one: np.ndarray) -> np.ndarray:
        return np.asarray(ours(*arguments[:place], one, *arguments[place + 1 :]))

    found = casadis.call([casadi.DM(each) for each in arguments])[0].full().ravel()
    expected = np.asarray(ours(*arguments), dtype=float)
    np.testing.assert_array_equal(np.isnan(found), np.isnan(expected))
    ordinary = size + np.abs(expected)
    arrays = [k for k, each in enumerate(arguments) if np.ndim(each) and np.size(each)]
    either_way = [
        1 + np.finfo(float).eps * rng.choice([-1, 1], size=(4, np.size(arguments[k]))) for k in arrays
    ]
    apart = np.abs(found - expected) - 1e-12 * ordinary
    if np.any(apart > 0):  # what needs no more allowance is not asked how it rounds, which takes long
        rounded = [
            rounding(partial(with_changed, k), arguments[k], one)
            for k, one in zip(arrays, either_way, strict=True)
        ]
        # What leaps, as random numbers do, would allow anything.
        apart -= np.minimum(np.max(rounded, axis=0), 1e-8 * ordinary)
    assert not np.any(apart > 0), f"beyond by {np.nanmax(apart)} at {np.nanargmax(apart)}"
    return expected


def rounding(of: Callable[[np.ndarray], np.ndarray], at: np.ndarray, either_way: np.ndarray) -> np.ndarray:
    """Ten times what a function's values move when each of its numbers is rounded once, and when none is.

    A reading takes from a covariance of thousands of squared kelvins all but a hundredth, and neighbouring
    nodes exchange nearly equal heats: what is left has the rounding of what was there. That within the
    function shows where it computes with longer numbers.
    """
    others = [*(at * each for each in either_way), at.astype(np.longdouble)]
    return 10 * np.nan_to_num(np.abs([of(other) - of(at) for other in others]).max(axis=0))


def flat(instance: Instance) -> tuple[np.ndarray, np.ndarray]:
    c = instance.component
    p = np.array([instance.get(name) for name in c.p.names])
    return p, np.array([instance.get(name) for name in c.u.names])


# Rows of a table come from C alone: `packaging/native/test_tables.py` compares those with NumPy's.
@pytest.mark.parametrize("name", [name for name, each in ALL.items() if not each.tables])
@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 10**6))
@example(seed=234834)  # an observer's gain for all thermometers at once, off by 2e-12 of 1
def test_casadi_and_numpy_compute_the_same(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    component, written = ALL[name], in_casadi(name)
    instance = varied(component, rng)
    p, u = flat(instance)
    declared = sizes([*component.parameters, *component.derived])
    d = same(written["settled"], component.settled, (p,), declared, rng)
    size, x = sizes(component.states), np.zeros(0)
    if component.states:
        x = same(written["begin"], component.states_at_start, (u, d), size, rng)
    for k in range(1, 5):
        time, shown = k * 17.0, sizes(component.outputs)
        same(written["outputs"], component.outputs_of, (x, u, d, time), shown, rng)
        feed(instance, rng)
        u = flat(instance)[1]
        if component.sampled:
            step = d[component.p.index["sample_time"]]
            x = same(written["update"], component.updated, (x, u, d, time, step), size, rng)
        elif component.rates is not None:
            x = x + rng.normal(size=x.size) * 5
            same(written["rates"], component.rates_of, (x, u, d, time), size, rng)


@pytest.mark.parametrize("name", CONTINUOUS)
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_the_complex_step_gives_casadis_jacobians(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    component = ALL[name]
    instance = varied(component, rng)
    p, u = flat(instance)
    d = np.asarray(component.settled(p), dtype=float)
    x = np.asarray(component.states_at_start(u, d), dtype=float) + rng.normal(size=component.x.size) * 5
    _, by_state, by_input = in_casadi(name)["rates"](x, u, d, 60.0)

    size = component.x.size
    found = ComplexStepJacobian(np.ones((size, size), dtype=bool))(
        lambda z: component.rates_of(z, u, d, 60.0), x
    )
    by_state = by_state.full()
    assert found == pytest.approx(by_state, rel=1e-11, abs=1e-12 * np.abs(by_state).max())
    for i in range(component.u.size):
        stepped = u.astype(complex)
        stepped[i] += 1e-30j
        slope = np.imag(component.rates_of(x, stepped, d, 60.0)) / 1e-30
        assert slope == pytest.approx(by_input.full()[:, i], rel=1e-11, abs=1e-14)


# Rows of a table come from C alone: `packaging/native/test_tables.py` compares those with NumPy's.
@pytest.mark.parametrize("name", [name for name, each in ALL.items() if each.sampled])
def test_a_sample_falls_on_time_however_the_run_is_cut(name: str) -> None:
    """Steps of 0.1 s, of 1 s and one of 60 s with the inputs held come to the same, bit for bit."""
    ends = []
    for step, count in ((0.1, 600), (1.0, 60), (60.0, 1)):
        instance = varied(ALL[name], np.random.default_rng(5))
        feed(instance, np.random.default_rng(6), nan=False)
        instance.initialize()
        for k in range(count):
            instance.step(k * step, step)
        ends.append(instance.snapshot().states)
    assert np.array_equal(ends[0], ends[1], equal_nan=True)
    assert np.array_equal(ends[1], ends[2], equal_nan=True)


@pytest.mark.parametrize("name", ALL)
def test_declared_values_are_allowed_and_give_finite_outputs(name: str) -> None:
    instance = Instance(ALL[name])
    instance.initialize()
    assert np.all(np.isfinite(instance.outputs()))
    instance.step(0.0, 10.0)
    assert np.all(np.isfinite(instance.outputs()))

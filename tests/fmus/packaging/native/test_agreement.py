"""Native FMU and Python instance agree, in what they compute and in what they refuse."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.component import Component, Input, Output, Parameter, Scalar
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.errors import InputError

from .conftest import BuildNative
from .running import DISCARD, Native, refused

COMPONENTS = {entry.component.name: entry.component for entry in catalogue()}
LARGE = ("Remainder", "LinearObserverCompensator", "ObserverCompensator", "ObserverDriftCompensator")
CASES = [
    (name, version)
    for name in COMPONENTS
    for version in ("2.0", "3.0")
    if version == "3.0" or name not in LARGE
]
"""What is generated is the same for both versions; the large ones, which take long in Python, run as one."""


@pytest.fixture(scope="module", params=CASES, ids=lambda case: f"{case[0]}-{case[1]}")
def pair(request: pytest.FixtureRequest, native_fmu: BuildNative) -> Iterator[tuple[Component, Native]]:
    name, version = request.param
    native = Native(native_fmu(name, version), COMPONENTS[name])
    yield COMPONENTS[name], native
    native.close()


def _parameter(scalar: Scalar) -> st.SearchStrategy[float]:
    """Start value, or another near it; whole where it must be, and never sampling a long step to death."""
    variable, start = scalar.variable, scalar.start
    assert start is not None
    if variable.type != "Real":
        low = variable.minimum if variable.minimum is not None else min(start, 0)
        return st.integers(
            int(low), int(variable.maximum if variable.maximum is not None else start + 3)
        ).map(float)
    low = max(start * 0.8 if start else 0.0, scalar.lower if scalar.lower is not None else -math.inf)
    high = start * 1.25 if start else 0.2 * (variable.nominal or 1.0)
    if variable.maximum is not None:
        high = min(high, variable.maximum)
    if scalar.name == "sample_time":
        low, high = 1.0, 30.0
    return st.one_of(st.just(start), st.floats(min(low, high), max(low, high)))


def _input(scalar: Scalar) -> st.SearchStrategy[float]:
    variable = scalar.variable
    if variable.type == "Boolean":
        return st.sampled_from([0.0, 1.0])
    if variable.type == "Integer":
        return st.integers(int(variable.minimum or 0), int(variable.maximum or 3)).map(float)
    if variable.unit == "K":
        values = st.floats(250.0, 380.0)
    else:
        size = variable.nominal or 1.0
        high = 3 * size if variable.maximum is None else min(3 * size, variable.maximum)
        values = st.floats(max(-size, variable.minimum if variable.minimum is not None else -size), high)
    accepts = isinstance(variable, Input) and variable.accepts_nan
    return st.one_of(values, st.just(math.nan)) if accepts else values


def _steps(component: Component) -> st.SearchStrategy[float]:
    """Any length, in s; a sampled component computes every sample of it, so that a minute is enough there."""
    longest = 60.0 if component.sampled else 600.0
    return st.floats(math.log(0.01), math.log(longest)).map(math.exp)


@settings(max_examples=8, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_random_runs_agree(pair: tuple[Component, Native], data: st.DataObject) -> None:
    component, native = pair
    instance = Instance(component)
    native.fmu.reset()
    scalars = list(component.scalars())
    parameters = [s for s in scalars if isinstance(s.variable, Parameter)]
    chosen = (
        data.draw(st.lists(st.sampled_from(parameters), max_size=6, unique=True), "parameters")
        if parameters
        else []
    )
    values = {s.name: data.draw(_parameter(s), s.name) for s in chosen}
    inputs = {s.name: _input(s) for s in scalars if isinstance(s.variable, Input)}
    values |= data.draw(st.fixed_dictionaries(inputs), "inputs")
    start = data.draw(st.sampled_from([0.0, 0.0, 17.25]), "start")

    instance.set(values)
    instance.begin(start)
    native.set(values)
    native.enter(start)
    refusal = _refusal(instance.initialize)
    if refusal is not None:
        assert refused(native, native.fmu.exitInitializationMode) == refusal
        return
    _assert_equal(component, instance, native)
    native.fmu.exitInitializationMode()

    time = start
    for number in range(data.draw(st.integers(1, 4), "steps")):
        step = data.draw(_steps(component), f"step {number}")
        values = data.draw(st.fixed_dictionaries(inputs), "inputs")
        instance.set(values)
        native.set(values)
        refusal = _refusal(lambda at=time, by=step: instance.step(at, by))
        if refusal is not None:
            assert refused(native, lambda at=time, by=step: native.step(at, by)) == refusal
            return
        native.step(time, step)
        time += step
        _assert_equal(component, instance, native)


def _refusal(action: Callable[[], None]) -> str | None:
    try:
        action()
    except InputError as error:
        return str(error)
    return None


def _assert_equal(component: Component, instance: Instance, native: Native) -> None:
    for scalar in component.scalars():
        if isinstance(scalar.variable, Output):
            ours, theirs = instance.get(scalar.name), native.get(scalar.name)
            size = max(abs(ours), scalar.variable.nominal or 1.0)
            assert (math.isnan(ours) and math.isnan(theirs)) or abs(ours - theirs) <= 1e-9 * size, (
                scalar.name,
                ours,
                theirs,
            )


def test_each_refusal_has_the_sentence_of_the_python_instance(pair: tuple[Component, Native]) -> None:
    component, native = pair
    for scalar in component.scalars():
        for value in _bad_values(scalar):
            instance = Instance(component)
            native.fmu.reset()
            native.messages.clear()
            if isinstance(scalar.variable, Parameter):
                instance.set({scalar.name: value})
                native.set({scalar.name: value})
                native.enter()
                with pytest.raises(InputError) as sentence:
                    instance.initialize()
                assert refused(native, native.fmu.exitInitializationMode) == str(sentence.value)
            else:
                instance.begin()
                instance.initialize()
                native.initialize()
                instance.set({scalar.name: value})
                native.set({scalar.name: value})
                with pytest.raises(InputError) as sentence:
                    instance.step(0.0, 1.0)
                assert refused(native, lambda: native.step(0.0, 1.0), DISCARD) == str(sentence.value)


@pytest.mark.parametrize("value", [2.0**-24, 5e-324, 1 / 3e7, 9e-7])
def test_a_number_in_a_sentence_is_written_alike(native_fmu: BuildNative, value: float) -> None:
    component = COMPONENTS["TemperatureSensors"]
    native = Native(native_fmu(component.name, "2.0"), component)
    instance = Instance(component)
    instance.set({"quantum[1]": value})
    instance.begin()
    native.set({"quantum[1]": value})
    native.enter()
    with pytest.raises(InputError) as sentence:
        instance.initialize()
    assert refused(native, native.fmu.exitInitializationMode) == str(sentence.value)
    native.close()


def _bad_values(scalar: Scalar) -> list[float]:
    variable = scalar.variable
    if isinstance(variable, Output) or variable.type == "Boolean":
        return []
    bad = []
    if variable.type == "Real":
        bad.append(math.inf)
        if not (isinstance(variable, Input) and variable.accepts_nan):
            bad.append(math.nan)
    if variable.minimum is not None:
        bad.append(float(variable.minimum - 1))
    if variable.maximum is not None:
        bad.append(float(variable.maximum + 12345))
    if isinstance(variable, Parameter) and variable.positive:
        bad += [0.0, -0.02]
    return bad

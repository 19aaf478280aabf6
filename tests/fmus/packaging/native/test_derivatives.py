"""Directional derivatives, input derivatives, output derivatives, and FMI 3.0's intermediate update."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.heater.component import COMPONENT as HEATER
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.packaging.native.fmu import FmiVersion
from warmlink.fmus.thermal_link.component import COMPONENT as LINK

from .conftest import BuildNative
from .running import DISCARD, Native, refused

END = 240.0


@pytest.fixture(params=["2.0", "3.0"])
def link(request: pytest.FixtureRequest, native_fmu: BuildNative) -> Iterator[Native]:
    native = Native(native_fmu("ThermalLink", request.param), LINK, "link")
    yield native
    native.close()


def fine(component: Component, inputs: Callable[[float], dict[str, float]], output: str, end: float) -> float:
    """Output after a run in which the inputs follow closely what they should be."""
    instance = Instance(component)
    instance.set(inputs(0.0))
    instance.begin()
    instance.initialize()
    step = 0.25
    for i in range(round(end / step)):
        # The middle of a step carries a linear or parabolic input to second order.
        instance.set(inputs((i + 0.5) * step))
        instance.step(i * step, step)
    return instance.get(output)


def coarse(native: Native, inputs: dict[str, Callable[[float], float]], step: float, order: int) -> float:
    """Elongation at the end, with derivatives of the inputs up to an order given at each step."""
    native.fmu.reset()
    native.set({name: f(0.0) for name, f in inputs.items()})
    native.initialize()
    references = native.references(inputs)
    small = 1e-3
    for i in range(round(END / step)):
        time = i * step
        native.set({name: f(time) for name, f in inputs.items()})
        for k in range(1, order + 1):
            slopes = [_derivative(f, time, k, small) for f in inputs.values()]
            native.fmu.setRealInputDerivatives(references, [k] * len(references), slopes)
        native.step(time, step)
    return native.get("elongation")


def _derivative(f: Callable[[float], float], time: float, order: int, small: float) -> float:
    if order == 1:
        return (f(time + small) - f(time - small)) / (2 * small)
    return (f(time + small) - 2 * f(time) + f(time - small)) / small**2


def test_input_derivatives_raise_the_order(native_fmu: BuildNative) -> None:
    native = Native(native_fmu("ThermalLink", "2.0"), LINK)
    inputs = {"heat_flow": lambda t: 5 + 4 * math.sin(t / 40), "speed": lambda t: 3 + math.cos(t / 60)}
    exact = fine(LINK, lambda t: {name: f(t) for name, f in inputs.items()}, "elongation", END)
    steps = (20.0, 10.0)
    for order, least in ((0, 0.8), (1, 1.7), (2, 2.6)):
        errors = [abs(coarse(native, inputs, step, order) - exact) for step in steps]
        observed = math.log2(errors[0] / errors[1])
        assert observed > least, f"order {order}: {observed:.2f}"
    native.close()


def test_a_parabola_acts_inside_the_micro_steps(native_fmu: BuildNative) -> None:
    native = Native(native_fmu("ThermalLink", "2.0"), LINK)

    def power(t: float) -> float:
        return 2 + 0.05 * t + 4e-4 * t**2

    native.set({"heat_flow": power(0.0)})
    native.initialize()
    native.fmu.setRealInputDerivatives(native.references(["heat_flow", "heat_flow"]), [1, 2], [0.05, 8e-4])
    native.step(0.0, END)
    exact = 2 * END + 0.05 * END**2 / 2 + 4e-4 * END**3 / 3
    # ROS2 takes each micro step's input by the trapezoidal rule, of second order.
    assert native.get("heat_received") == pytest.approx(exact, rel=1e-5)
    assert native.get("heat_flow") == pytest.approx(power(END))
    # The derivatives were of that step alone.
    native.step(END, 10.0)
    assert native.get("heat_received") - exact == pytest.approx(10 * power(END), rel=1e-3)
    native.close()


def test_derivatives_that_lead_out_of_range_are_refused(native_fmu: BuildNative) -> None:
    native = Native(native_fmu("ThermalLink", "2.0"), LINK, "link")
    native.initialize()
    native.fmu.setRealInputDerivatives(native.references(["ambient_temperature"]), [1], [-100.0])
    sentence = refused(native, lambda: native.step(0.0, 10.0), DISCARD)
    assert sentence == "link.ambient_temperature: -704.85 K is too low; give at least 0 K"
    for wrong in (["elongation"], ["width"]):
        sentence = refused(
            native, lambda w=wrong: native.fmu.setRealInputDerivatives(native.references(w), [1], [1.0])
        )  # type: ignore[misc]
        assert "takes no derivative" in sentence
    heat = native.references(["heat_flow"])
    assert "of order 3" in refused(native, lambda: native.fmu.setRealInputDerivatives(heat, [3], [1.0]))
    native.close()


def test_output_derivatives_are_those_of_the_outputs(link: Native) -> None:
    link.set({"heat_flow": 6.0, "speed": 2.0})
    link.initialize()
    link.step(0.0, 300.0)
    names = ["elongation", "tip_temperature", "heat_received"]
    references = link.references(names)
    if link.modern:
        slopes = list(link.fmu.getOutputDerivatives(references, [1] * 3))
    else:
        slopes = list(link.fmu.getRealOutputDerivatives(references, [1] * 3))
    before = [link.get(name) for name in names]
    small = 0.01
    link.step(300.0, small)
    after = [link.get(name) for name in names]
    assert slopes == pytest.approx([(b - a) / small for a, b in zip(before, after, strict=True)], rel=1e-3)
    call = link.fmu.getOutputDerivatives if link.modern else link.fmu.getRealOutputDerivatives
    assert "no derivative of order 2" in refused(link, lambda: call(references[:1], [2]))


def test_output_derivatives_follow_the_inputs(native_fmu: BuildNative) -> None:
    motor = Native(native_fmu("MotorHeatSource", "2.0"), MOTOR)
    motor.initialize()
    motor.fmu.setRealInputDerivatives(motor.references(["link_base_temperature"]), [1], [0.5])
    motor.step(0.0, 2.0)
    # Q = G (T_s - T_base): at first the shaft stands still.
    (slope,) = motor.fmu.getRealOutputDerivatives(motor.references(["heat_flow"]), [1])
    assert slope == pytest.approx(-0.5, rel=1e-2)
    assert motor.get("link_base_temperature") == pytest.approx(295.15 + 1.0)
    motor.close()


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("phase", ["initialization", "run"])
def test_directional_derivatives_against_a_complex_step(
    version: FmiVersion, phase: str, native_fmu: BuildNative
) -> None:
    motor = Native(native_fmu("MotorHeatSource", version), MOTOR)
    values = {"link_base_temperature": 301.0, "neighbour_conductance": 0.3}
    motor.set(values)
    motor.enter()
    if phase == "run":
        motor.fmu.exitInitializationMode()
        motor.step(0.0, 60.0)
    knowns = [name for name in MOTOR.u.names if name != "pad_mode"]
    unknowns = list(MOTOR.y.names)
    seed = np.linspace(1.0, 2.0, len(knowns))
    given = motor.fmu.getDirectionalDerivative(
        motor.references(unknowns), motor.references(knowns), list(seed)
    )

    instance = Instance(MOTOR)
    instance.set(values)
    instance.begin()
    if phase == "run":
        instance.initialize()
        instance.step(0.0, 60.0)
    instance.outputs()
    u = np.array([instance.get(name) for name in MOTOR.u.names], dtype=complex)
    u[[MOTOR.u.index[name] for name in knowns]] += 1e-30j * seed
    d = MOTOR.settled(np.array([instance.get(name) for name in MOTOR.p.names]))
    x = np.array(instance.snapshot().states) if phase == "run" else MOTOR.states_at_start(u, d)
    expected = np.imag(np.asarray(MOTOR.outputs_of(x, u, d, instance.time), dtype=complex)) / 1e-30
    assert list(given) == pytest.approx(list(expected), rel=1e-12)
    assert any(expected)
    motor.close()


def test_a_directional_derivative_by_what_is_no_input(link: Native) -> None:
    link.initialize()
    length, elongation = link.references(["length", "elongation"])
    derivative = link.fmu.getDirectionalDerivative
    assert "is no input" in refused(link, lambda: derivative([elongation], [length], [1.0]))
    assert "is no output" in refused(link, lambda: derivative([length], [LINK.p.size], [1.0]))


def test_derivatives_of_a_component_without_states(native_fmu: BuildNative) -> None:
    heater = Native(native_fmu("Heater", "2.0"), HEATER)
    heater.initialize()
    assert heater.fmu.getRealOutputDerivatives(heater.references([HEATER.y.names[0]]), [1])[
        0
    ] == pytest.approx(0.0)
    heater.close()


def test_intermediate_update_lets_inputs_vary_within_the_step(native_fmu: BuildNative) -> None:
    times: list[float] = []
    holder: list[Native] = []

    def update(
        _: Any,
        time: float,
        wanted: bool,
        allowed: bool,
        finished: bool,
        may_end: bool,
        end: Any,
        end_time: Any,
    ) -> None:
        assert wanted != finished
        assert allowed == finished
        assert not may_end
        if wanted:
            times.append(time)
            holder[0].set({"heat_flow": 5 + 4 * math.sin(time / 40)})

    native = Native(
        native_fmu("ThermalLink", "3.0"),
        LINK,
        intermediateUpdate=update,
        requiredIntermediateVariables=[LINK.p.size],
    )
    holder.append(native)
    native.set({"heat_flow": 5.0})
    native.initialize()
    native.step(0.0, END)
    assert times == [float(i) for i in range(1, 241)]
    exact = fine(LINK, lambda t: {"heat_flow": 5 + 4 * math.sin(t / 40)}, "elongation", END)
    assert native.get("elongation") == pytest.approx(exact, rel=1e-4)
    native.close()


def test_an_intermediate_update_may_end_the_step_early(native_fmu: BuildNative) -> None:
    asked = 7.3

    def update(
        _: Any,
        time: float,
        wanted: bool,
        allowed: bool,
        finished: bool,
        may_end: bool,
        end: Any,
        end_time: Any,
    ) -> None:
        if finished and time >= 5.0:
            assert may_end
            end[0], end_time[0] = True, asked

    native = Native(
        native_fmu("ThermalLink", "3.0"), LINK, intermediateUpdate=update, earlyReturnAllowed=True
    )
    native.set({"heat_flow": 5.0})
    native.initialize()
    _, _, early, reached = native.step(0.0, 20.0)
    assert (early, reached) == (True, asked)
    assert native.get("heat_received") == pytest.approx(5.0 * asked)
    native.close()


def test_a_bad_input_within_the_step_leaves_everything_as_it_was(native_fmu: BuildNative) -> None:
    holder: list[Native] = []

    def update(
        _: Any,
        time: float,
        wanted: bool,
        allowed: bool,
        finished: bool,
        may_end: bool,
        end: Any,
        end_time: Any,
    ) -> None:
        if wanted:
            holder[0].set({"heat_flow": math.nan if time > 3 else 4.0})

    native = Native(native_fmu("ThermalLink", "3.0"), LINK, "link", intermediateUpdate=update)
    holder.append(native)
    native.set({"heat_flow": 5.0})
    native.initialize()
    assert "link.heat_flow: nan W is not a number" in refused(native, lambda: native.step(0.0, 20.0), DISCARD)
    assert native.get("heat_received") == 0.0
    assert native.get("heat_flow") == 5.0
    native.close()

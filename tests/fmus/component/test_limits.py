"""What may not be is refused in one sentence that names variable, value, unit and remedy."""

import math
from collections.abc import Mapping
from dataclasses import replace

import pytest

from warmlink.fmus.component import Parameter
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import components

ALL = components()

REFUSED = [
    ("ThermalLink", {"width": -0.02}, "link.width: -0.02 m is not positive; give a value above 0 m"),
    ("ThermalLink", {"length": math.nan}, "link.length: nan m is not a number; give a value"),
    ("ThermalLink", {"density": math.inf}, "link.density: inf kg/m3 is not finite; give a finite value"),
    ("ThermalLink", {"emissivity": 4.5}, "link.emissivity: 4.5 is too high; give at most 1"),
    (
        "ThermalLink",
        {"convection_still": -1.0},
        "link.convection_still: -1 W/(m2.K) is too low; give at least 0 W/(m2.K)",
    ),
    (
        "ThermalLink",
        {"tip_position": 0.4},
        "link.tip_position: 0.4 m lies beyond the link's end; keep it within length (0.3302 m)",
    ),
    (
        "ThermalLink",
        {"base_position": 0.3},
        None,
    ),
    (
        "ThermalLink",
        {"base_position": 0.317},
        "link.base_position: 0.317 m leaves no length before tip_position (0.317 m) on a link of "
        "length 0.3302 m; put it nearer the proximal end, or correct the others",
    ),
    (
        "ThermalLink",
        {"length": 20.0, "base_position": 0.305},
        "link.base_position: 0.305 m leaves no length before tip_position (0.317 m) on a link of length "
        "20 m; put it nearer the proximal end, or correct the others",
    ),
    ("ThermalLink", {"length": 460.0}, "link.length: 460 m is too high; give at most 20 m"),
    ("ThermalLink", {"thickness": 6.35}, "link.thickness: 6.35 m is too high; give at most 1 m"),
    (
        "ThermalLink",
        {"sensor_position[5]": 0.5},
        "link.sensor_position[5]: 0.5 m lies beyond the link's end; keep it within length (0.3302 m)",
    ),
    (
        "MotorHeatSource",
        {"torque_constant": 0.0},
        "link.torque_constant: 0 N.m/A is not positive; give a value above 0 N.m/A",
    ),
    ("TemperatureSensors", {"lag[3]": -1.0}, "link.lag[3]: -1 s is too low; give at least 0 s"),
    ("TemperatureSensors", {"seed": 1.5}, "link.seed: 1.5 is not a whole number; give one"),
    ("TemperatureSensors", {"fault_kind[8]": 5}, "link.fault_kind[8]: 5 is too high; give at most 4"),
    (
        "DriftCamera",
        {"delay": 45.0},
        "link.delay: 45 s is longer than the time between two pictures; keep it within moving_interval "
        "(30 s) and still_interval (120 s)",
    ),
    ("DutyCycle", {"duration[2]": 1e300}, "link.duration[2]: 1e+300 s is too high; give at most 1e+08 s"),
    ("PoseSequence", {"duration[1]": 1e300}, "link.duration[1]: 1e+300 s is too high; give at most 1e+08 s"),
    ("DutyCycle", {"segment_pad_mode[2]": 3}, "link.segment_pad_mode[2]: 3 is too high; give at most 2"),
    ("Heater", {"power": -6.0}, "link.power: -6 W is too low; give at least 0 W"),
    (
        "LagCompensator",
        {"time_constant": 0.0},
        "link.time_constant: 0 s is not positive; give a value above 0 s",
    ),
    ("AnalyticCompensator", {"form": 2}, "link.form: 2 is too high; give at most 1"),
]


@pytest.mark.parametrize(("name", "values", "sentence"), REFUSED)
def test_parameters(name: str, values: Mapping[str, float], sentence: str | None) -> None:
    instance = Instance(ALL[name], "link")
    instance.set(values)
    if sentence is None:
        instance.initialize()
        return
    with pytest.raises(InputError) as refusal:
        instance.initialize()
    assert str(refusal.value) == sentence


@pytest.mark.parametrize("name", ALL)
def test_every_parameter_refuses_nan_and_says_which(name: str) -> None:
    for scalar in ALL[name].scalars():
        if not isinstance(scalar.variable, Parameter):
            continue
        instance = Instance(ALL[name], "it")
        instance.set({scalar.name: math.nan})
        with pytest.raises(InputError, match="is not a number; give a value") as refusal:
            instance.initialize()
        assert str(refusal.value).startswith(f"it.{scalar.name}: ")


def test_inputs_that_cope_with_nan_take_it_and_others_do_not() -> None:
    law = Instance(ALL["AnalyticCompensator"])
    law.initialize()
    law.set({"base_temperature": math.nan})
    law.step(0.0, 1.0)
    motor = Instance(ALL["MotorHeatSource"], "motor")
    motor.initialize()
    motor.set({"torque": math.nan})
    with pytest.raises(InputError, match=r"motor\.torque: nan N\.m is not a number"):
        motor.step(0.0, 1.0)


@pytest.mark.parametrize("name", [name for name, each in ALL.items() if each.sampled])
@pytest.mark.parametrize("period", [0.0, 1e-9, 1e-300])
def test_a_sample_time_that_would_never_end_is_refused(name: str, period: float) -> None:
    instance = Instance(ALL[name], "it")
    instance.set({"sample_time": period})
    with pytest.raises(InputError) as refusal:
        instance.initialize()
    assert str(refusal.value) == f"it.sample_time: {period:g} s is too low; give at least 0.001 s"


def test_what_samples_must_declare_the_shortest_sample_time() -> None:
    sensors = ALL["TemperatureSensors"]
    others = tuple(each for each in sensors.parameters if each.name != "sample_time")
    for declared in ((), (Parameter("sample_time", "s", 1.0, "period", positive=True),)):
        with pytest.raises(ValueError, match=r"sample_time with a minimum of at least 0\.001 s"):
            replace(sensors, parameters=(*others, *declared))


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize(
    ("time", "step", "sentence"),
    [
        (0.0, 1e7, "it: a step of 1e+07 s; give one above 0 s and at most 10000 s"),
        (0.0, math.inf, "it: a step of inf s; give one above 0 s and at most 10000 s"),
        (0.0, math.nan, "it: a step of nan s; give one above 0 s and at most 10000 s"),
        (1e9, 1.0, "it: a step from 1e+09 s, but 0 s is reached; step from there, or restore a state"),
    ],
)
def test_no_step_takes_for_ever(name: str, time: float, step: float, sentence: str) -> None:
    instance = Instance(ALL[name], "it")
    instance.initialize()
    with pytest.raises(InputError) as refusal:
        instance.step(time, step)
    assert str(refusal.value) == sentence
    instance.step(0.0, 1.0)


def test_a_state_that_is_not_finite_refuses_the_step_and_leaves_the_instance() -> None:
    camera = Instance(ALL["DriftCamera"], "camera")
    camera.initialize()
    before = camera.snapshot()
    camera.set({"elongation": 1e308, "correction": -1e308})
    camera.set_reference(camera.component.p.size + 2, 1.0)
    with pytest.raises(InputError, match=r"camera: seen is not finite after 0 s; look for inputs"):
        camera.step(0.0, 60.0)
    assert (camera.snapshot().states, camera.snapshot().samples) == (before.states, before.samples)


def test_an_unknown_variable_an_output_and_a_late_parameter() -> None:
    motor = Instance(ALL["MotorHeatSource"], "motor")
    with pytest.raises(InputError, match=r"motor\.colour: MotorHeatSource has no such variable"):
        motor.set({"colour": 1.0})
    with pytest.raises(InputError, match=r"motor\.heat_flow: an output cannot be set"):
        motor.set({"heat_flow": 1.0})
    with pytest.raises(InputError, match="a step before initialization"):
        motor.step(0.0, 1.0)
    motor.initialize()
    with pytest.raises(InputError, match="parameters are fixed once the run has begun"):
        motor.set({"joint_conductance": 1.0})
    with pytest.raises(InputError, match="a step of -1 s; give one above 0 s"):
        motor.step(0.0, -1.0)

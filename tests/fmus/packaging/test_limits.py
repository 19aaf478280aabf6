"""What may not be is refused in one sentence that names variable, value, unit and remedy."""

import math
from collections.abc import Mapping

import pytest

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.component import Parameter
from warmlink.fmus.packaging.instance import Instance
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
        "link.base_position: 0.317 m leaves no stretch before tip_position (0.317 m); put it nearer the "
        "proximal end",
    ),
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
        motor.set({"pad_gain": 1.0})
    with pytest.raises(InputError, match="a step of -1 s; give one above 0 s"):
        motor.step(0.0, -1.0)

"""The inside of a Python FMU without a host: nothing is raised, and no refusal is passed over in silence."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.packaging.python.slave import ComponentSlave

REFERENCES = {scalar.name: scalar.reference for scalar in MOTOR.scalars()}
DUTY = {"speed": 3.0, "torque": 2.5}
STEP = 2.0


class MotorSlave(ComponentSlave):
    component = MOTOR
    form = "motor_1"


class LaterSlave(MotorSlave):
    form = "motor_2"


def slave(begun: bool = True, kind: type[MotorSlave] = MotorSlave, **values: float) -> MotorSlave:
    made = kind(instance_name="motor")
    put(made, **DUTY, **values)
    made.setup_experiment(0.0)
    if begun:
        made.exit_initialization_mode()
    return made


def put(motor: MotorSlave, **values: float) -> None:
    motor.set_real([REFERENCES[name] for name in values], [*values.values()])


def outputs(motor: MotorSlave) -> list[float]:
    return motor.get_real([REFERENCES[name] for name in MOTOR.y.names])


def told(motor: MotorSlave) -> list[str]:
    said = [message.msg for message in motor.log_queue]
    motor.log_queue.clear()
    return said


def test_it_computes_what_the_instance_does() -> None:
    motor, instance = slave(), Instance(MOTOR, "motor")
    instance.set(DUTY)
    instance.initialize()
    for k in range(5):
        assert motor.do_step(STEP * k, STEP)
        instance.step(STEP * k, STEP)
    assert outputs(motor) == instance.outputs().tolist()
    assert told(motor) == []


def test_a_refused_step_leaves_everything_and_may_be_repeated() -> None:
    motor, undisturbed = slave(), slave()
    before = outputs(motor)
    put(motor, speed=math.nan)
    assert not motor.do_step(0.0, STEP)
    assert told(motor) == ["motor.speed: nan rad/s is not a number; give a value"]
    put(motor, **DUTY)
    assert outputs(motor) == before
    assert motor.do_step(0.0, STEP)
    assert undisturbed.do_step(0.0, STEP)
    assert outputs(motor) == outputs(undisturbed)


@pytest.mark.parametrize("restores", [True, False], ids=["restores", "repeats"])
def test_a_host_that_goes_on_after_a_refused_step_reads_no_old_values(restores: bool) -> None:
    motor = slave()
    saved = motor._get_fmu_state()
    put(motor, speed=math.inf)
    assert not motor.do_step(0.0, STEP)
    put(motor, **DUTY)
    assert not motor.do_step(STEP, STEP)
    assert "the step from 0 s was refused; repeat that one or restore a state" in told(motor)[-1]
    assert all(map(math.isnan, outputs(motor)))
    assert motor.get_real([REFERENCES["speed"]]) == [DUTY["speed"]]
    if restores:
        motor._set_fmu_state(saved)
        assert all(map(math.isfinite, outputs(motor)))
    assert motor.do_step(0.0, STEP)
    assert all(map(math.isfinite, outputs(motor)))


@pytest.mark.parametrize(
    ("kind", "name", "nothing"),
    [("integer", "speed", 0), ("boolean", "speed", False), ("real", None, math.nan)],
)
def test_a_variable_that_there_is_not_costs_one_step(kind: str, name: str | None, nothing: float) -> None:
    motor = slave()
    reference = 10_000 if name is None else REFERENCES[name]
    (value,) = getattr(motor, f"get_{kind}")([reference])
    assert value == nothing or (math.isnan(nothing) and math.isnan(value))
    (sentence,) = told(motor)
    assert f"no {kind.capitalize()} variable has the value reference {reference}" in sentence
    assert not motor.do_step(0.0, STEP)
    assert told(motor) == [sentence]
    assert motor.do_step(0.0, STEP)


def test_what_was_refused_before_the_run_began_costs_no_step() -> None:
    motor = slave(begun=False)
    motor.set_real([10_000], [1.0])
    motor.exit_initialization_mode()
    assert len(told(motor)) == 1
    assert motor.do_step(0.0, STEP)


def test_parameters_out_of_range_are_told_at_the_end_of_initialization_and_let_no_step_pass() -> None:
    motor = slave(winding_heat_capacity=-1.0)
    (sentence,) = told(motor)
    assert "winding_heat_capacity: -1 J/K is not positive" in sentence
    for _ in range(2):
        assert not motor.do_step(0.0, STEP)
        assert told(motor) == [sentence]
    assert all(map(math.isnan, outputs(motor)))


def test_a_state_goes_through_bytes_bit_for_bit_even_where_an_input_is_nan() -> None:
    motor, other = slave(), slave(begun=False)
    assert motor.do_step(0.0, STEP)
    put(motor, torque=math.nan)
    other._set_fmu_state(
        MotorSlave._fmu_state_from_bytes(MotorSlave._fmu_state_to_bytes(motor._get_fmu_state()))
    )
    assert math.isnan(other.get_real([REFERENCES["torque"]])[0])
    for each in (motor, other):
        put(each, torque=1.0)
        assert each.do_step(STEP, STEP)
    assert outputs(motor) == outputs(other)


def test_what_was_saved_does_not_change_with_what_follows() -> None:
    motor = slave()
    put(motor, winding_heat_capacity=1.0)  # in the run, so that the next step is refused
    saved, as_bytes = motor._get_fmu_state(), MotorSlave._fmu_state_to_bytes
    before = as_bytes(saved)
    put(motor, winding_heat_capacity=2.0)
    assert as_bytes(saved) == before
    assert not motor.do_step(0.0, STEP)
    assert motor.do_step(0.0, STEP)
    assert as_bytes(saved) == before
    motor._set_fmu_state(saved)
    assert not motor.do_step(0.0, STEP)
    assert as_bytes(saved) == before


def test_a_byte_that_differs_makes_a_state_damaged() -> None:
    motor = slave()
    assert motor.do_step(0.0, STEP)
    whole = MotorSlave._fmu_state_to_bytes(motor._get_fmu_state())
    before = outputs(motor)
    for place in range(len(MotorSlave.form) + 1, len(whole), 7):
        motor._set_fmu_state(MotorSlave._fmu_state_from_bytes(flipped(whole, place)))
        assert told(motor) == ["the serialised state is damaged; serialise it anew"], place
        assert not motor.do_step(STEP, STEP)
        assert outputs(motor) == before
        told(motor)
    assert motor.do_step(STEP, STEP)


def test_a_state_that_no_instance_could_have_is_damaged_whatever_its_digest() -> None:
    motor = slave()
    saved = motor._get_fmu_state()
    assert saved.snapshot is not None
    early = replace(saved, snapshot=replace(saved.snapshot, time=-STEP))
    motor._set_fmu_state(MotorSlave._fmu_state_from_bytes(MotorSlave._fmu_state_to_bytes(early)))
    assert told(motor) == ["the serialised state is damaged; serialise it anew"]


def flipped(content: bytes, place: int) -> bytes:
    return content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :]


def test_a_state_of_another_version_is_refused_as_that() -> None:
    motor = slave()
    theirs = LaterSlave._fmu_state_to_bytes(slave(kind=LaterSlave)._get_fmu_state())
    motor._set_fmu_state(MotorSlave._fmu_state_from_bytes(theirs))
    assert told(motor) == ["the serialised state belongs to another version of this FMU"]
    assert not motor.do_step(0.0, STEP)

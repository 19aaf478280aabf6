"""Wrong use gets the status that the standard asks for and a line in the log, and changes nothing."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import pytest
from fmpy.fmi1 import FMICallException

from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR

from .conftest import BuildNative
from .running import Native, refused


@pytest.fixture(params=["2.0", "3.0"])
def motor(request: pytest.FixtureRequest, native_fmu: BuildNative) -> Iterator[Native]:
    native = Native(native_fmu("MotorHeatSource", request.param), MOTOR, "motor")
    yield native
    native.close()


def running(motor: Native) -> Native:
    motor.set({"speed": 3.0, "torque": 2.0})
    motor.initialize(stop=100.0)
    motor.step(0.0, 1.0)
    return motor


AFTER_START: dict[str, tuple[Callable[[Native], object], str]] = {
    "negative step": (lambda m: m.step(1.0, -1.0), "motor: a step of -1 s; give one above 0 s"),
    "no step": (lambda m: m.step(1.0, 0.0), "motor: a step of 0 s; give one above 0 s"),
    "NaN step": (lambda m: m.step(1.0, math.nan), "motor: a step of nan s; give one above 0 s"),
    "another time": (lambda m: m.step(7.0, 1.0), "motor: a step from 7 s, but 1 s is reached"),
    "NaN time": (lambda m: m.step(math.nan, 1.0), "motor: a step from nan s, but 1 s is reached"),
    "beyond the stop time": (lambda m: m.step(1.0, 200.0), "motor: a step to 201 s, beyond the stop time"),
    "a parameter late": (
        lambda m: m.set({"torque_constant": 2.0}),
        "motor.torque_constant: parameters are fixed once the run has begun; set it before initialization",
    ),
    "an output set": (
        lambda m: m.set({"heat_flow": 2.0}),
        "motor.heat_flow: an output cannot be set; set an input",
    ),
    "initialization again": (lambda m: m.enter(), "belongs in instantiation, not in"),
    "end of initialization again": (
        lambda m: m.fmu.exitInitializationMode(),
        "belongs in initialization mode, not in",
    ),
}


@pytest.mark.parametrize("wrong", AFTER_START)
def test_wrong_use_in_the_run(motor: Native, wrong: str) -> None:
    action, sentence = AFTER_START[wrong]
    running(motor)
    before = [motor.get(name) for name in MOTOR.y.names]
    assert sentence in refused(motor, lambda: action(motor))
    assert [motor.get(name) for name in MOTOR.y.names] == before
    # The instance goes on as if nothing had been asked of it.
    motor.step(1.0, 1.0)


def test_a_step_before_initialization(motor: Native) -> None:
    expected = "motor: a step before initialization; initialize it first"
    assert refused(motor, lambda: motor.step(0.0, 1.0)) == expected


def test_a_step_after_the_end(motor: Native) -> None:
    running(motor)
    motor.fmu.terminate()
    assert "a step after the end" in refused(motor, lambda: motor.step(1.0, 1.0))
    assert "the run has ended" in refused(motor, lambda: motor.set({"speed": 1.0}))
    assert motor.get("shaft_temperature") > 295.15


def test_a_run_that_ends_before_it_starts(motor: Native) -> None:
    assert "a run from 5 s to 3 s" in refused(motor, lambda: motor.enter(5.0, 3.0))


@pytest.mark.parametrize("act", ["get", "set"])
def test_an_unknown_value_reference(motor: Native, act: str) -> None:
    running(motor)
    kind = "Float64" if motor.modern else "Real"
    last = len(motor.scalars) - 1
    call = getattr(motor.fmu, act + kind)
    extra = [] if act == "get" else [[1.0]]
    sentence = refused(motor, lambda: call([last + 5], *extra))
    assert sentence == f"motor: value reference {last + 5} is unknown; MotorHeatSource has 0 to {last}"


def test_a_value_reference_of_another_type(motor: Native) -> None:
    (reference,) = motor.references(["pad_mode"])
    get = motor.fmu.getFloat64 if motor.modern else motor.fmu.getReal
    assert refused(motor, lambda: get([reference])) == "motor.pad_mode: is an integer, not a real number"


def test_text_is_refused(motor: Native) -> None:
    assert "no " in refused(motor, lambda: motor.fmu.getString([0]))


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_an_input_that_is_no_number(motor: Native, value: float) -> None:
    running(motor)
    motor.set({"torque": value})
    assert "motor.torque: " in refused(motor, lambda: motor.step(1.0, 1.0))
    motor.set({"torque": 1.0})
    motor.step(1.0, 1.0)


@pytest.mark.parametrize("damage", ["another version", "too short", "another component"])
def test_a_serialised_state_of_another_version(motor: Native, damage: str) -> None:
    running(motor)
    state = motor.fmu.getFMUState() if motor.modern else motor.fmu.getFMUstate()
    content = bytes(
        motor.fmu.serializeFMUState(state) if motor.modern else motor.fmu.serializeFMUstate(state)
    )
    if damage == "another version":
        content = content[:9] + b"0" * 32 + content[41:]
    elif damage == "too short":
        content = content[:-8]
    else:
        content = bytes(len(content))
    read = motor.fmu.deserializeFMUState if motor.modern else motor.fmu.deSerializeFMUstate
    sentence = refused(motor, lambda: read(content))
    assert sentence.startswith("motor: the serialised state is not of this version of MotorHeatSource")
    (motor.fmu.freeFMUState if motor.modern else motor.fmu.freeFMUstate)(state)


def test_another_token_is_refused(motor: Native) -> None:
    motor.fmu.guid = "{00000000-0000-0000-0000-000000000000}"
    live, messages = motor.fmu.component, []
    options = {"logMessage": lambda *call: messages.append(call[-1].decode())} if motor.modern else {}
    with pytest.raises(Exception, match="instantiate"):
        motor.fmu.instantiate(**options)
    motor.fmu.component = live
    if motor.modern:
        assert messages[0].startswith("MotorHeatSource: the instantiation token is not that of this FMU")


def test_event_mode_is_refused(native_fmu: BuildNative) -> None:
    with pytest.raises(Exception, match="instantiate"):
        Native(native_fmu("MotorHeatSource", "3.0"), MOTOR, eventModeUsed=True)


def test_statuses_that_belong_to_asynchronous_steps(native_fmu: BuildNative) -> None:
    motor = running(Native(native_fmu("MotorHeatSource", "2.0"), MOTOR, "motor"))
    assert motor.fmu.getRealStatus(2) == 1.0
    assert motor.fmu.getBooleanStatus(3) == 0
    assert "not asynchronous" in refused(motor, motor.fmu.cancelStep)
    with pytest.raises(FMICallException):
        motor.fmu.getStatus(0)
    motor.close()

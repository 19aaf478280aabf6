"""Wrong use gets the status that the standard asks for and a line in the log, and changes nothing."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterator
from ctypes import addressof, c_size_t, c_void_p

import pytest
from fmpy.fmi1 import FMICallException

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.drift_camera.component import COMPONENT as CAMERA
from warmlink.fmus.errors import InputError
from warmlink.fmus.heater.component import COMPONENT as HEATER
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR

from .conftest import BuildNative
from .running import DISCARD, Native, refused


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
    "a step that would not end": (
        lambda m: m.step(1.0, 1e7),
        "motor: a step of 1e+07 s; give one above 0 s and at most 10000 s",
    ),
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
    sentence = refused(motor, lambda: call([last + 50], *extra))
    assert sentence == f"motor: value reference {last + 50} is unknown; MotorHeatSource has 0 to {last}"


def test_a_value_reference_of_another_type(motor: Native) -> None:
    (reference,) = motor.references(["pad_mode"])
    get = motor.fmu.getFloat64 if motor.modern else motor.fmu.getReal
    assert refused(motor, lambda: get([reference])) == "motor.pad_mode: is an enumeration, not a real number"


def test_text_is_refused(motor: Native) -> None:
    assert "no " in refused(motor, lambda: motor.fmu.getString([0]))


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_an_input_that_is_no_number(motor: Native, value: float) -> None:
    running(motor)
    motor.set({"torque": value})
    assert "motor.torque: " in refused(motor, lambda: motor.step(1.0, 1.0), DISCARD)
    motor.set({"torque": 1.0})
    motor.step(1.0, 1.0)


@pytest.fixture(params=["2.0", "3.0"])
def heater(request: pytest.FixtureRequest, native_fmu: BuildNative) -> Iterator[Native]:
    native = Native(native_fmu("Heater", request.param), HEATER, "heater")
    native.initialize()
    yield native
    native.close()


@pytest.mark.parametrize(("given", "taken"), [(1.0000000000000002, 1.0), (-1e-17, 0.0)])
def test_an_input_beside_its_bound_by_a_rounding_error_is_taken_for_the_bound(
    heater: Native, given: float, taken: float
) -> None:
    for i in range(3):
        heater.set({"on": given})
        heater.step(float(i), 1.0)
        assert heater.get("on") == taken
    assert heater.get("heat_delivered") == 3 * 6 * taken
    assert heater.messages == [f"heater.on: {given!r} is taken for {taken:g}, here and from now on"]


def test_the_python_form_takes_it_for_the_bound_too() -> None:
    python, warnings = Instance(HEATER), []
    python.warn = warnings.append
    python.initialize()
    for i in range(2):
        python.set({"on": 1.0000000000000002})
        python.step(float(i), 1.0)
        assert python.get("on") == 1.0
    assert warnings == ["heater.on: 1.0000000000000002 is taken for 1, here and from now on"]
    python.set({"on": 1.00000001})
    with pytest.raises(InputError, match=r"heater\.on: 1\.00000001 is too high; give at most 1$"):
        python.step(2.0, 1.0)


def test_an_input_beyond_its_bound_discards_the_step(heater: Native) -> None:
    heater.set({"on": 1.00000001})
    sentence = refused(heater, lambda: heater.step(0.0, 1.0), DISCARD)
    assert sentence == "heater.on: 1.00000001 is too high; give at most 1"
    heater.set({"on": 1.0})
    heater.step(0.0, 1.0)


def test_time_is_not_settable(native_fmu: BuildNative) -> None:
    motor = running(Native(native_fmu("MotorHeatSource", "3.0"), MOTOR, "motor"))
    time = [len(motor.scalars)]
    assert motor.fmu.getFloat64(time) == [1.0]
    sentence = refused(motor, lambda: motor.fmu.setFloat64(time, [2.0]))
    assert sentence == "motor.time: cannot be set; it goes on with the steps"
    motor.close()


NULL_CALLS = {
    "2.0": {
        "GetReal": lambda n: (None, n, None),
        "SetReal": lambda n: (None, n, None),
        "GetInteger": lambda n: (None, n, None),
        "SetBoolean": lambda n: (None, n, None),
        "GetString": lambda n: (None, n, None),
        "SetRealInputDerivatives": lambda n: (None, n, None, None),
        "GetRealOutputDerivatives": lambda n: (None, n, None, None),
        "GetDirectionalDerivative": lambda n: (None, n, None, n, None, None),
    },
    "3.0": {
        "GetFloat64": lambda n: (None, n, None, n),
        "SetFloat64": lambda n: (None, n, None, n),
        "GetInt32": lambda n: (None, n, None, n),
        "GetInt64": lambda n: (None, n, None, n),
        "SetBoolean": lambda n: (None, n, None, n),
        "GetBinary": lambda n: (None, n, None, None, n),
        "SetClock": lambda n: (None, n, None),
        "GetOutputDerivatives": lambda n: (None, n, None, None, n),
        "GetDirectionalDerivative": lambda n: (None, n, None, n, None, n, None, n),
    },
}


@pytest.mark.parametrize("count", [0, 1, 7])
def test_null_arrays_are_well_where_nothing_is_asked_and_refused_elsewhere(motor: Native, count: int) -> None:
    running(motor)
    for name, arguments in NULL_CALLS["3.0" if motor.modern else "2.0"].items():
        function = getattr(motor.fmu.dll, f"fmi{3 if motor.modern else 2}{name}")
        function.argtypes = None
        values = [c_size_t(each) if isinstance(each, int) else each for each in arguments(count)]
        motor.messages.clear()
        assert function(c_void_p(motor.fmu.component), *values) == (3 if count else 0), name
        assert len(motor.messages) == (1 if count else 0), name
    motor.step(1.0, 1.0)


@pytest.mark.parametrize("act", ["Get", "Set"])
@pytest.mark.parametrize("kind", ["Real", "Integer", "Boolean"])
def test_either_array_may_be_missing(motor: Native, act: str, kind: str) -> None:
    running(motor)
    named = {"Real": "Float64", "Integer": "Int32"}.get(kind, kind) if motor.modern else kind
    function = getattr(motor.fmu.dll, f"fmi{3 if motor.modern else 2}{act}{named}")
    function.argtypes = None
    room = c_void_p(addressof((c_size_t * 4)()))
    for given in ((None, room), (room, None)):
        sizes = [c_size_t(1)] * (2 if motor.modern else 1)
        assert function(c_void_p(motor.fmu.component), given[0], sizes[0], given[1], *sizes[1:]) == 3
        assert motor.messages[-1].startswith("motor: a null pointer in place of an array")


@pytest.mark.parametrize("order", [1, 2])
def test_sampled_components_take_no_input_derivatives(native_fmu: BuildNative, order: int) -> None:
    camera = Native(native_fmu("DriftCamera", "2.0"), CAMERA, "camera")
    camera.initialize()
    reference = camera.references(["elongation"])
    call = lambda: camera.fmu.setRealInputDerivatives(reference, [order], [0.0])  # noqa: E731
    assert "takes no derivative" in refused(camera, call)
    camera.close()


def stored(motor: Native) -> bytes:
    state = motor.fmu.getFMUState() if motor.modern else motor.fmu.getFMUstate()
    content = motor.fmu.serializeFMUState(state) if motor.modern else motor.fmu.serializeFMUstate(state)
    (motor.fmu.freeFMUState if motor.modern else motor.fmu.freeFMUstate)(state)
    return bytes(content)


def stamped(content: bytes) -> bytes:
    """With the digest of what stands before it, as the C code writes it."""
    digest = 14695981039346656037
    for byte in content[:-8]:
        digest = (digest ^ byte) * 1099511628211 % 2**64
    return content[:-8] + struct.pack("<Q", digest)


SLOPE = 5 + MOTOR.x.size + 2 * MOTOR.u.size - MOTOR.u.index["pad_mode"]
DAMAGED = {
    "phase": (1, [-1.0, 0.5, 4.0, 7.0, 1e300, math.nan, math.inf], "phase"),
    "interpolates": (0, [3.0, -1.0, math.nan], "derivatives"),
    "an integer's slope": (SLOPE, [1.0, math.nan], "derivatives"),
    "samples": (2, [1.0, -1.0, 1e300, math.nan], "samples"),
    "time": (3, [math.nan, math.inf, -1e9, 1e300], "times"),
    "stop time": (4, [math.nan, -1e9], "times"),
    "start time": (5, [math.nan, -math.inf, 1e9], "times"),
    "a state": (6, [math.nan, -math.inf], "not finite"),
    "a parameter": (-1, [math.nan, -1.0], "parameter"),
}
"""Number of each field, counted from the end of the state, or the first from its beginning."""


@pytest.mark.parametrize("field", DAMAGED)
def test_a_damaged_state_is_refused_in_a_sentence(motor: Native, field: str) -> None:
    place, values, word = DAMAGED[field]
    running(motor)
    content, before = stored(motor), [motor.get(name) for name in MOTOR.y.names]
    assert stamped(content) == content
    at = len("warmlink ") + 32 if place < 0 else len(content) - 8 * (place + 2)
    read = motor.fmu.deserializeFMUState if motor.modern else motor.fmu.deSerializeFMUstate
    for value in values:
        damaged = content[:at] + struct.pack("<d", value) + content[at + 8 :]
        assert "its digest differs" in refused(motor, lambda bad=damaged: read(bad))
        refused(motor, lambda bad=damaged: read(stamped(bad)))
        assert word in motor.messages[-1], motor.messages[-1]
    assert [motor.get(name) for name in MOTOR.y.names] == before
    motor.step(1.0, 1.0)


@pytest.mark.parametrize("damage", ["another version", "too short", "another component"])
def test_a_serialised_state_of_another_version(motor: Native, damage: str) -> None:
    running(motor)
    content = stored(motor)
    if damage == "another version":
        content = content[:9] + b"0" * 32 + content[41:]
    elif damage == "too short":
        content = content[:-8]
    else:
        content = bytes(len(content))
    read = motor.fmu.deserializeFMUState if motor.modern else motor.fmu.deSerializeFMUstate
    sentence = refused(motor, lambda: read(content))
    assert sentence.startswith("motor: the serialised state is not of this version of MotorHeatSource")


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

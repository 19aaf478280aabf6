"""Use an FMU of MotorHeatSource in every wrong way; what it answers is asserted here, in this process."""

from __future__ import annotations

import gc
import hashlib
import json
import math
import struct
import sys

from slave import OK, Slave

DISCARD = 2
fmu = sys.argv[1]
cold = {"speed": 3.0, "torque": 2.0}


def refused(slave: Slave, time: float, step: float, *words: str) -> None:
    slave.messages.clear()
    assert slave.step(time, step) == DISCARD
    (sentence,) = slave.sentences("logStatusDiscard")
    assert all(word in sentence for word in words), sentence


# Parameters out of range are held until the first step, and never recovered from.
bad = Slave(fmu).initialize(cold | {"joint_conductance": -1.0})
refused(bad, 0.0, 1.0, "one.joint_conductance: -1 W/K is too low", "give at least 0 W/K")
assert all(map(math.isnan, bad.get("heat_flow", "shaft_temperature")))

# An input out of range refuses the step and leaves everything as it was.
slave = Slave(fmu).initialize(cold)
assert slave.step(0.0, 1.0) == OK
before = slave.bits()
slave.set({"torque": math.nan})
refused(slave, 1.0, 1.0, "one.torque", "not a number")
slave.set({"torque": 2.0})
assert slave.bits() == before
assert slave.step(1.0, 1.0) == OK

# A host that goes on all the same reads NaN until it restores a state.
slave.set({"pad_mode": 7})
state = slave.fmu.getFMUState()
refused(slave, 2.0, 1.0, "one.pad_mode", "at most 2")
slave.set({"pad_mode": 0})
refused(slave, 3.0, 1.0, "from 3 s", "from 2 s was refused")
assert math.isnan(*slave.get("heat_flow"))
slave.fmu.setFMUState(state)
assert slave.get("heat_flow") != [math.nan]
slave.set({"pad_mode": 0})
assert slave.step(2.0, 1.0) == OK

# Parameters are fixed, outputs are not set, references must exist: heard at once, and by the next step.
slave.messages.clear()
slave.set({"joint_conductance": 2.0})
assert "fixed once the run has begun" in slave.sentences("logStatusError")[0]
refused(slave, 3.0, 1.0, "joint_conductance")
assert slave.get("joint_conductance") == [1.0]
assert slave.step(3.0, 1.0) == OK
slave.set({"heat_flow": 1.0})
refused(slave, 4.0, 1.0, "heat_flow: an output cannot be set")
for reference in (999, 2**32 - 1, slave.variables["pad_mode"].valueReference):
    assert math.isnan(*slave.fmu.getReal([reference]))
    refused(slave, 4.0, 1.0, "no Real variable has the value reference")
slave.fmu.getString([0])
refused(slave, 4.0, 1.0, "no String variable")
refused(slave, 4.0, -1.0, "a step of -1 s")
assert slave.step(4.0, 1.0) == OK

# A step that would not end, and one from elsewhere.
refused(slave, 5.0, 1e7, "a step of 1e+07 s; give one above 0 s and at most 10000 s")
refused(slave, 5.0, math.inf, "a step of inf s")
refused(slave, 1e9, 1.0, "from 1e+09 s")
assert slave.step(5.0, 1.0) == OK

# Serialised states that are broken or of another version are not taken, stamped anew or not.
stored = slave.fmu.serializeFMUState(slave.fmu.getFMUState())
before = slave.bits()
other = stored.replace(b"warmlink_motor_heat_source_", b"warmlink_motor_heat_source_0", 1)
form, _, content = stored.split(b" ", 2)


def stamped(content: bytes) -> bytes:
    return b" ".join((form, hashlib.sha256(content).hexdigest()[:16].encode(), content))


def with_field(name: str, value: object) -> bytes:
    """The stored state with another value in it, its digest right all the same."""
    state = json.loads(content)
    (state["snapshot"] if name in state["snapshot"] else state)[name] = value
    return stamped(json.dumps(state).encode())


assert stamped(content) == stored
kept = json.loads(content)["snapshot"]
nan = struct.pack("<d", math.nan).hex()
for wrong, word in (
    (stored[:-9], "damaged"),
    (b"\xff\x00", "damaged"),
    (stored.replace(b"6.0", b"7.0"), "damaged"),
    (other, "another version"),
    *((stamped(each), "damaged") for each in (b"", b"[" * 10**5, b"null", b"{}", b'{"snapshot": 5}')),
    *((with_field("time", value), "damaged") for value in (math.nan, math.inf, -1e9, "now", None, [1.0])),
    *((with_field("start_time", value), "damaged") for value in (math.nan, 1e9, 10**400, True)),
    *((with_field("samples", value), "damaged") for value in (1, -1, 10**30, 0.5, "many")),
    *((with_field("initialized", value), "damaged") for value in (False, 1, None, "yes")),
    *((with_field("states", value), "damaged") for value in ("", "zz", nan + kept["states"][16:], [1, 2])),
    *((with_field("parameters", value), "damaged") for value in (nan + kept["parameters"][16:], 5)),
    *((with_field("inputs", value), "damaged") for value in (nan, nan + kept["inputs"][16:])),
    *((with_field("unfit", value), "damaged") for value in (5, ["x"])),
    *((with_field("refused", value), "damaged") for value in (None, "x", [5])),
    *((with_field(name, 7), "damaged") for name in ("discarded", "lost", "other")),
):
    ruin = slave.fmu.deSerializeFMUstate(wrong)
    slave.fmu.setFMUState(ruin)
    refused(slave, 6.0, 1.0, word)
# Nor does it become one by being serialised anew.
slave.fmu.setFMUState(slave.fmu.deSerializeFMUstate(slave.fmu.serializeFMUState(ruin)))
refused(slave, 6.0, 1.0, "damaged")
assert slave.bits() == before
assert slave.step(6.0, 1.0) == OK

# A step before initialization.
early = Slave(fmu)
refused(early, 0.0, 1.0, "before initialization")

# Reset begins anew.
slave.fmu.reset()
slave.fmu.setupExperiment(startTime=0.0)
slave.initialize(cold)
assert slave.step(0.0, 1.0) == OK
twin = Slave(fmu).initialize(cold)
assert twin.step(0.0, 1.0) == OK
assert twin.bits() == slave.bits()

# Many instances: the script's globals must outlive each of them.
name = next(name for name in sys.modules if name.startswith("warmlink_") and name.endswith("_slave"))
count = sys.getrefcount(vars(sys.modules[name]))
for _ in range(50):
    Slave(fmu).fmu.freeInstance()
gc.collect()
assert abs(sys.getrefcount(vars(sys.modules[name])) - count) <= 1
assert twin.step(1.0, 1.0) == OK
print(json.dumps("survived"))

"""Flags beside readings do what NaN does, and no NaN is left."""

from __future__ import annotations

import math

import pytest

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.join import join
from warmlink.fmus.packaging.views import flag_of, flagged

COMPONENTS = {entry.component.name: entry.component for entry in catalogue()}
SENSORS, CAMERA = COMPONENTS["TemperatureSensors"], COMPONENTS["DriftCamera"]
PLACES = ["shaft", "winding", "base", "middle", "tip"]
WIRES = [
    *((f"sensors.reading[{i}]", f"law.{place}_temperature") for i, place in enumerate(PLACES, start=1)),
    ("camera.measured_drift", "law.measured_drift"),
    ("camera.drift_valid", "law.drift_valid"),
    ("law.correction", "camera.correction"),
]
DROPOUTS = {
    "sensors.fault_kind[1]": 4,
    "sensors.fault_time[1]": 40,
    "sensors.fault_kind[5]": 4,
    "sensors.fault_time[5]": 0,
    "camera.fault_kind": 4,
    "camera.fault_time": 100,
}


def test_only_what_has_readings_gets_flags() -> None:
    changed = {name for name, component in COMPONENTS.items() if flagged(component) is not component}
    assert changed == {name for name in COMPONENTS if "Compensator" in name} | {SENSORS.name, CAMERA.name}
    assert [v.name for v in flagged(SENSORS).outputs] == ["reading", "reading_valid"]
    assert not any("NaN" in v.description for part in (SENSORS, CAMERA) for v in flagged(part).outputs)


def loop(law: Component, flags: bool) -> Instance:
    parts = {"sensors": SENSORS, "camera": CAMERA, "law": law}
    wires = list(WIRES)
    if flags:
        parts = {name: flagged(part) for name, part in parts.items()}
        wires += [(flag_of(a), flag_of(b)) for a, b in WIRES if "reading" in a or "measured" in a]
    instance = Instance(join("Loop", parts, wires))
    instance.set(DROPOUTS)
    for i in range(1, 9):
        instance.set({f"sensors.temperature[{i}]": 295.15, f"sensors.noise[{i}]": 0.05})
    instance.set({"law.speed": 3.0, "law.torque": 2.0, "camera.speed": 3.0})
    instance.initialize()
    return instance


@pytest.mark.parametrize("name", ["LagCompensator", "ObserverDriftCompensator"])
def test_a_loop_with_flags_does_what_one_with_nan_does(name: str) -> None:
    bare, told = loop(COMPONENTS[name], False), loop(COMPONENTS[name], True)
    last = {"sensors.reading[5]": 300.0}
    lost = {"sensors.reading[1]": 40, "sensors.reading[5]": 0, "camera.measured_drift": 120}
    for k in range(140):
        for instance in (bare, told):
            instance.set({"camera.elongation": 1e-7 * k, "sensors.temperature[1]": 295.15 + 0.02 * k})
            instance.step(float(k), 1.0)
        for output in COMPONENTS[name].y.names:
            assert told.get(f"law.{output}") == bare.get(f"law.{output}")
        for reading, since in lost.items():
            known = not math.isnan(bare.get(reading))
            assert known == (k + 1 < since)
            assert bool(told.get(flag_of(reading))) == known
            assert told.get(reading) == (bare.get(reading) if known else last[reading])
        last |= {reading: told.get(reading) for reading in lost}


def test_before_any_reading_it_is_the_nominal_value() -> None:
    instance = Instance(flagged(SENSORS))
    instance.set({"fault_kind[1]": 4})
    instance.initialize()
    assert [instance.get(f"reading[{i}]") for i in (1, 2)] == [300.0, 295.15]
    assert [instance.get(f"reading_valid[{i}]") for i in (1, 2)] == [0, 1]

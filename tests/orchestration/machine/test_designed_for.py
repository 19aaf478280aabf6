"""What a law is designed for: motors and links of a machine, found by its wires."""

from __future__ import annotations

from dataclasses import replace

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration import catalogue
from warmlink.orchestration.machine.machine import Machine
from warmlink.orchestration.machine.plant import plant_of
from warmlink.orchestration.machine.shipped import WARMUP_CELL, machine_named
from warmlink.orchestration.system.units import Conversion
from warmlink.orchestration.written.expression import Expression


def designed(machine: Machine, **values: dict[str, float]) -> object:
    return plant_of(machine, machine.declared(catalogue.controller("none")), values)


def test_temperatures_are_those_behind_the_thermometers() -> None:
    plant = plant_of(
        WARMUP_CELL, WARMUP_CELL.declared(catalogue.controller("none")), {"link": {"length": 0.4, "seed": 1}}
    )
    assert (plant.motors, plant.links) == (("motor",), ("link",))
    assert plant.read["base_temperature"] == "link.base_temperature"
    assert plant.read["shaft_temperature"] == "motor.shaft_temperature"
    assert plant.growth == {"link.elongation": 1.0}
    assert plant.given == {"link.length": 0.4}, "what is no parameter of the plant is left out"


def test_a_thermometer_that_no_wire_feeds_is_not_read() -> None:
    wires = tuple(wire for wire in WARMUP_CELL.wires if not wire[1].endswith(".tip_temperature"))
    plant = plant_of(
        replace(WARMUP_CELL, wires=wires), WARMUP_CELL.declared(catalogue.controller("none")), {}
    )
    assert "tip_temperature" not in plant.read
    assert "base_temperature" in plant.read


def test_what_cannot_be_designed_for_is_said() -> None:
    with pytest.raises(InputError, match="BenchRod: a design needs motors and links"):
        designed(machine_named("BenchRod"))
    target = WARMUP_CELL.wires[0][1]
    with pytest.raises(InputError, match=r"a connection scales what it carries.*take .*law.*linear_observer"):
        designed(replace(WARMUP_CELL, scaled={target: Conversion(2.0, 0.0)}))
    roles = replace(WARMUP_CELL.roles, score=Expression("camera.reading - compensator.correction", "score"))
    with pytest.raises(
        InputError, match=r"camera\.reading is scored, which is no output of its motors and links"
    ):
        designed(replace(WARMUP_CELL, roles=roles))

"""A cause of one kind of part stands once for each of them; one of several kinds for the machine."""

from __future__ import annotations

from warmlink.orchestration.diagnosis.causes.catalogue import Cause, catalogue
from warmlink.orchestration.diagnosis.causes.parts import freed_in_parts
from warmlink.orchestration.machine.machine import Machine
from warmlink.orchestration.machine.rig import Rig

CAUSES: dict[str, Cause] = {each.name: each for each in catalogue()}
TWO = Rig(
    Machine(
        "Two",
        "",
        dict.fromkeys(("one", "two"), "MotorHeatSource") | {"arm": "ThermalLink"},
        (("one.heat_flow", "arm.heat_flow"), ("arm.base_temperature", "one.link_base_temperature")),
    )
)
NEXT = Rig(
    Machine(
        "Next",
        "",
        dict(TWO.machine.parts),
        (*TWO.machine.wires, ("arm.tip_temperature", "two.neighbour_temperature")),
    )
)


def test_there_is_one_case_for_each_part_of_the_kind() -> None:
    assert freed_in_parts(CAUSES["joint_resistance"], TWO) == {
        f"joint_resistance:{name}": (f"{name}.joint_resistance",) for name in ("one", "two")
    }
    assert freed_in_parts(CAUSES["radiation"], TWO) == {"radiation": ("arm.emissivity",)}


def test_a_cause_of_motors_and_links_is_that_of_all() -> None:
    found = freed_in_parts(CAUSES["ambient_drift"], TWO)
    assert found == {"ambient_drift": ("one.ambient_drift", "two.ambient_drift", "arm.ambient_drift")}


def test_what_no_part_has_is_no_case() -> None:
    only = Rig(Machine("Only", "", {"arm": "ThermalLink"}))
    assert freed_in_parts(CAUSES["joint_resistance"], only) == {}


def test_a_cause_that_needs_an_input_waits_for_a_wire_or_a_column() -> None:
    cause = CAUSES["neighbour_heat"]
    assert freed_in_parts(cause, TWO) == {}
    assert freed_in_parts(cause, TWO, lambda name: name == "one.neighbour_temperature") == {
        "neighbour_heat": ("one.neighbour_conductance",)
    }
    assert freed_in_parts(cause, NEXT) == {"neighbour_heat": ("two.neighbour_conductance",)}

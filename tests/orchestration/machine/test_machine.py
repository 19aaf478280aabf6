"""Machines: shipped ones are data, and what is made of them follows from the data alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import components, controller
from warmlink.orchestration.diagnosis.answer.separation import DUTIES, ONE_AT_A_TIME, drives, duties_of
from warmlink.orchestration.machine import shipped
from warmlink.orchestration.machine.machine import KINDS
from warmlink.orchestration.machine.read import NamedMachine, machine_in
from warmlink.orchestration.machine.rig import rig
from warmlink.orchestration.machine.shipped import LIBRARY, machine_named, machines


def test_every_file_of_the_library_is_a_machine_of_known_parts() -> None:
    assert set(machines()) == {path.stem for path in LIBRARY.glob("*.toml")}
    for name, about in machines().items():
        machine = machine_named(name)
        assert (machine.name, machine.about) == (name, about)
        assert machine.kinds <= set(components())
        law = controller("none") if machine.controllers else None
        assert machine.joined(law).name == name


def test_a_file_put_into_the_library_is_a_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = """
        about = "a motor beside a rod"
        [parts]
        drive = "MotorHeatSource"
        beam = "ThermalLink"
        [wires]
        "beam.heat_flow" = "drive.heat_flow"
        "drive.link_base_temperature" = "beam.base_temperature"
        [nominal.beam]
        length = 0.5
        [roles]
        score = "beam.elongation"
        uncompensated = "beam.elongation"
    """
    (tmp_path / "Beam.toml").write_text(text, "utf-8")
    monkeypatch.setattr(shipped, "LIBRARY", tmp_path)
    beam = machine_named("Beam")
    assert beam.called("motor") == ["drive"]
    assert beam.called("link") == ["beam"]
    assert beam.fed["beam.heat_flow"] == "drive.heat_flow"
    assert beam.roles.plant == ("beam.elongation",)
    (length,) = (each.start for each in beam.joined().scalars() if each.name == "beam.length")
    assert length == 0.5


def test_a_machine_that_is_not_there_is_refused_with_those_that_are() -> None:
    with pytest.raises(InputError, match=r"WarmupCel: no such machine; did you mean WarmupCell"):
        machine_named("WarmupCel")


def test_a_place_for_a_controller_wants_one() -> None:
    with pytest.raises(InputError, match="compensator is a controller's place; name a controller"):
        machine_named("WarmupCell").joined()


def test_each_kind_of_part_is_a_component_or_the_place_of_a_controller() -> None:
    assert {kind for kind in KINDS.values() if kind} <= set(components())


def test_what_a_duty_cycle_drives_follows_from_the_wires() -> None:
    cell, rod = (rig(name) for name in ("WarmupCell", "BenchRod"))
    assert cell.machine.driven["link.speed"] == "speed"
    assert cell.demanded["speed"] == ("motor.speed",), "one input stands for the signal"
    assert cell.input_behind("compensator.torque") == "motor.torque"
    assert not rod.demanded
    assert drives(ONE_AT_A_TIME, cell)
    assert not drives(ONE_AT_A_TIME, rod)
    assert duties_of(cell) == DUTIES
    assert duties_of(rod) == ()


def test_what_a_controller_should_take_out_is_what_is_scored_without_it() -> None:
    assert machine_named("WarmupCell").growth == {"link.elongation": 1.0}
    assert machine_named("BenchRod").growth == {"link.elongation": 1.0}, "of its only link"
    assert machine_named("BenchMotor").growth == {}
    assert machine_named("SixAxisArm").growth == {"kinematics.uncompensated_error_norm": 1.0}


@pytest.mark.parametrize(
    ("text", "named", "complaint"),
    [
        ('system = "other.toml"', "machine.toml", "give an SSP, or the name of a shipped machine"),
        ('system = "BenchRod"', "machine.toml", "machine.toml: system: choose SixAxisArm or WarmupCell"),
        ('system = "WarmupCell"\n[roles]\nscore = "a.b"', "machine.toml", "is shipped with its roles"),
        ("", "nowhere.ssp", "here: roles is missing"),
        ("", "WarmupCel", "here: system: did you mean WarmupCell"),
    ],
)
def test_a_machine_that_a_file_names_wrongly_is_refused(
    text: str, named: str, complaint: str, tmp_path: Path
) -> None:
    (tmp_path / "machine.toml").write_text(text, "utf-8")
    with pytest.raises(InputError, match=complaint):
        machine_in(NamedMachine(named, None, "here", tmp_path))


def test_the_compensator_is_every_place_of_a_controller_unless_a_part_is_called_so() -> None:
    cell, arm = machine_named("WarmupCell"), machine_named("SixAxisArm")
    assert cell.addressed("compensator.gain") == ["compensator.gain"]
    assert arm.addressed("compensator.gain") == [f"axis{i}.compensator.gain" for i in range(1, 7)]
    assert arm.addressed("motor.pad_gain") == ["motor.pad_gain"], "which is refused, as there is none"

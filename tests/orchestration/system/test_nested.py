"""A system written with systems inside it reads back as the flat one that it was."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest
from lxml import etree

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.assemble import component, connected, read_system
from warmlink.orchestration.system.model import Connection, DefaultExperiment, System
from warmlink.orchestration.system.write import write_ssp

from .ssp_text import LINK, MOTOR, Lab, fmi2
from .test_write_system import schema, without_places


@pytest.fixture
def arm(lab: Lab) -> System:
    """Two axes, one of them two systems deep, beside a motor that drives into both."""
    motor, link = lab.fmu("Motor", fmi2("Motor", MOTOR)), lab.fmu("Link", fmi2("Link", LINK))
    parts = {
        "motor": component("motor", motor, {"torque_constant": 2.0}),
        "one.motor": component("one.motor", motor),
        "one.link": component("one.link", link, {"length": 0.25}),
        "two.deep.link": component("two.deep.link", link, {"cells": 80}),
        "two.deep.rod": component("two.deep.rod", link),
        "two.motor": component("two.motor", motor),
    }
    connections = (
        *connected(
            parts,
            [
                ("one.motor.heat_flow", "one.link.heat_flow"),
                ("one.link.temperature", "one.motor.link_temperature"),
                ("one.link.temperature", "two.motor.link_temperature"),
                ("one.link.temperature", "two.deep.link.ambient"),
                ("one.link.temperature", "two.deep.rod.ambient"),
                ("two.motor.heat_flow", "two.deep.link.heat_flow"),
            ],
        ),
        Connection("two.deep.rod", "temperature", "one.motor", "ambient", 0.5, 100.0),
        *connected(
            parts,
            [
                ("motor.steps", "two.deep.rod.mode"),
                ("motor.steps", "one.motor.mode"),
                ("two.deep.link.temperature", "motor.ambient"),
            ],
        ),
    )
    return System("arm", parts, connections, DefaultExperiment(0.0, 60.0, 0.5))


def document(path: Path) -> etree._Element:
    with zipfile.ZipFile(path) as archive:
        return etree.fromstring(archive.read("SystemStructure.ssd"))


def test_what_is_nested_reads_back_flat(arm: System, tmp_path: Path) -> None:
    write_ssp(arm, tmp_path / "arm.ssp", nested=True)
    read = read_system(tmp_path / "arm.ssp", tmp_path / "work")
    assert without_places(read) == without_places(arm)
    assert set(read.connections) == set(arm.connections)
    assert len(read.connections) == len(arm.connections)
    assert read.default_experiment == arm.default_experiment
    assert read.remarks == ()
    write_ssp(read, tmp_path / "again.ssp", nested=True)
    again = read_system(tmp_path / "again.ssp", tmp_path / "work")
    assert set(again.connections) == set(arm.connections)


def test_it_stands_in_systems_and_meets_the_schema(arm: System, tmp_path: Path) -> None:
    write_ssp(arm, tmp_path / "arm.ssp", nested=True)
    root = document(tmp_path / "arm.ssp")
    schema("SystemStructureDescription.xsd").assertValid(root)
    systems = {
        each.get("name"): [part.get("name") for part in each.find("{*}Elements")]
        for each in root.iter("{*}System")
    }
    assert systems == {
        "arm": ["motor", "one", "two"],
        "one": ["motor", "link"],
        "two": ["motor", "deep"],
        "deep": ["link", "rod"],
    }


def test_one_connector_passes_a_source_into_a_system_however_many_take_it(
    arm: System, tmp_path: Path
) -> None:
    write_ssp(arm, tmp_path / "arm.ssp", nested=True)
    root = document(tmp_path / "arm.ssp")
    shown = {
        each.get("name"): [(c.get("name"), c.get("kind")) for c in each.findall("{*}Connectors/{*}Connector")]
        for each in root.iter("{*}System")
    }
    assert ("link_temperature", "output") in shown["one"]
    # Into `two` goes the temperature of `one`'s link once, for its motor and for both parts of `deep`.
    assert [name for name, kind in shown["two"] if kind == "input"] == [
        "motor_link_temperature",
        "deep_rod_mode",
    ]
    assert [name for name, kind in shown["deep"] if kind == "input"] == [
        "link_ambient",
        "link_heat_flow",
        "rod_mode",
    ]


def test_a_name_cannot_be_a_component_and_a_system(lab: Lab, tmp_path: Path) -> None:
    link = lab.fmu("Link", fmi2("Link", LINK))
    for names in (("one", "one.link"), ("one.link", "one")):
        parts = {name: component(name, link) for name in names}
        with pytest.raises(InputError, match="rename one"):
            write_ssp(System("arm", parts), tmp_path / "arm.ssp", nested=True)
    assert not (tmp_path / "arm.ssp").exists()

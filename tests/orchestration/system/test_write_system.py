"""Writing: what is written validates, reads back equal, is the same bytes each time, and nothing half."""

from __future__ import annotations

import importlib.util
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.assemble import check_system, component, connected, read_system
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import (
    Connection,
    Connector,
    DefaultExperiment,
    FmuPart,
    System,
)
from warmlink.orchestration.system.ssp.parameter_values import SsvValue, read_ssv, write_ssv
from warmlink.orchestration.system.units import Unit, parse_unit
from warmlink.orchestration.system.write import Ports, write_ssp

from .ssp_text import LINK, MOTOR, Lab, fmi2, ssd, system
from .test_description import FMI3

VALUES = {"length": 0.25, "cells": 80, "radiates": True, "label": 'a "<rod>" µ', "metal": 2, "ambient": 300.0}


@pytest.fixture
def made(lab: Lab) -> System:
    """A motor, two links of one FMU and one of FMI 3.0, with all that can be written."""
    motor, link = lab.fmu("Motor", fmi2("Motor", MOTOR)), lab.fmu("Link", fmi2("Link", LINK))
    parts = {
        "motor": component("motor", motor),
        "arm.link": component("arm.link", link, VALUES),
        "rod": component("rod", link, {"length": 1.0 / 3.0}),
        "third": component("third", lab.fmu("Link3", FMI3), {"metal": 1, "length": 0.5}),
    }
    connections = (
        *connected(
            parts,
            [
                ("motor.heat_flow", "arm.link.heat_flow"),
                ("arm.link.temperature", "motor.link_temperature"),
            ],
        ),
        Connection("arm.link", "temperature", "rod", "ambient", 0.5, 100.0),
        *connected(
            parts,
            [
                ("motor.steps", "rod.mode"),
                ("third.temperature", "motor.ambient"),
            ],
        ),
    )
    return System("cell", parts, connections, DefaultExperiment(1.0, 7200.0, 0.1))


def without_places(read: System) -> dict[str, tuple[str, bytes, dict[str, object]]]:
    return {
        name: (held.fmu.name, held.fmu.read_bytes(), dict(held.values))
        for name, held in read.components.items()
    }


def test_what_is_written_reads_back_equal(made: System, tmp_path: Path) -> None:
    write_ssp(made, tmp_path / "out/cell.ssp")
    read = read_system(tmp_path / "out/cell.ssp", tmp_path / "work")
    assert without_places(read) == without_places(made)
    assert list(read.components) == list(made.components)
    assert read.connections == made.connections
    shown = read.components["rod"].connectors.items()
    assert [(name, c.kind, c.unit and c.unit.name) for name, c in shown] == [
        ("ambient", "input", "K"),
        ("mode", "input", None),
        ("temperature", "output", "K"),
        ("elongation", "output", "m"),
        ("length", "parameter", "m"),
    ]
    assert read.default_experiment == made.default_experiment
    assert (read.name, read.remarks) == ("cell", ())
    # And what was read writes the same bytes again, from files that lie elsewhere.
    write_ssp(read, tmp_path / "again.ssp")
    assert (tmp_path / "again.ssp").read_bytes() == (tmp_path / "out/cell.ssp").read_bytes()


def test_equal_units_are_connected_as_they_are(made: System, tmp_path: Path) -> None:
    """What libcosim and Ecos read: no conversion but a LinearTransformation where one is needed."""
    write_ssp(made, tmp_path / "cell.ssp")
    with zipfile.ZipFile(tmp_path / "cell.ssp") as archive:
        root = etree.fromstring(archive.read("SystemStructure.ssd"))
    links = {
        (c.get("startElement"), c.get("startConnector")): [dict(t.attrib) for t in c]
        for c in root.iter("{*}Connection")
    }
    assert links[("motor", "heat_flow")] == []
    assert links[("arm.link", "temperature")] == [{"factor": "0.5", "offset": "100.0"}]


def schema(name: str) -> etree.XMLSchema:
    found = importlib.util.find_spec("fmpy")
    assert found is not None
    assert found.origin is not None
    return etree.XMLSchema(file=str(Path(found.origin).parent / "ssp/schema" / name))


def test_what_is_written_meets_the_schemas_of_ssp(made: System, tmp_path: Path) -> None:
    write_ssp(made, tmp_path / "cell.ssp")
    with zipfile.ZipFile(tmp_path / "cell.ssp") as archive:
        schema("SystemStructureDescription.xsd").assertValid(
            etree.fromstring(archive.read("SystemStructure.ssd"))
        )
        sets = [name for name in archive.namelist() if name.endswith(".ssv")]
        assert sets == ["resources/arm.link.ssv", "resources/rod.ssv", "resources/third.ssv"]
        for name in sets:
            schema("SystemStructureParameterValues.xsd").assertValid(etree.fromstring(archive.read(name)))


def test_the_bytes_are_the_same_each_time(made: System, tmp_path: Path) -> None:
    for name in ("one.ssp", "two.ssp"):
        write_ssp(made, tmp_path / name)
    assert (tmp_path / "one.ssp").read_bytes() == (tmp_path / "two.ssp").read_bytes()
    with zipfile.ZipFile(tmp_path / "one.ssp") as archive:
        assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def test_two_fmus_of_one_file_name_stay_apart(lab: Lab, tmp_path: Path) -> None:
    first = lab.fmu("Link", fmi2("Link", LINK))
    other = Lab(tmp_path / "other").fmu("Link", fmi2("Other", LINK))
    parts = {"a": component("a", first), "b": component("b", other)}
    write_ssp(System("cell", parts), tmp_path / "cell.ssp")
    read = read_system(tmp_path / "cell.ssp", tmp_path / "work")
    assert [read_description(c.fmu).model_name for c in read.components.values()] == ["Link", "Other"]


def test_names_that_are_no_file_names_and_names_that_differ_in_capitals(lab: Lab, tmp_path: Path) -> None:
    fmu = lab.fmu("a Link, 100%", fmi2("Link", LINK))
    parts = {name: component(name, fmu, {"length": 1.0}) for name in ("../x", "a/b", "Rod", "rod")}
    write_ssp(System("cell", parts), tmp_path / "cell.ssp")
    with zipfile.ZipFile(tmp_path / "cell.ssp") as archive:
        assert archive.namelist() == [
            "SystemStructure.ssd",
            "resources/.._x.ssv",
            "resources/Rod.ssv",
            "resources/a_Link__100_.fmu",
            "resources/a_b.ssv",
            "resources/rod-2.ssv",
        ]
    assert list(read_system(tmp_path / "cell.ssp", tmp_path / "work").components) == list(parts)


def test_a_unit_that_no_fmu_defines_is_kept(lab: Lab, tmp_path: Path) -> None:
    bare = lab.fmu("Bare", fmi2("Bare", tuple(v.replace('unit="m"', "") for v in LINK)))
    mil = Unit("mil", parse_unit("m").exponents, 2.54e-5)
    held = FmuPart("bare", bare, {"elongation": Connector("output", "Real", mil)})
    write_ssp(System("cell", {"bare": held}), tmp_path / "cell.ssp")
    read = read_system(tmp_path / "cell.ssp", tmp_path / "work")
    assert read.components["bare"].connectors == held.connectors


def test_on_failure_nothing_is_written(made: System, tmp_path: Path) -> None:
    wrong = System("cell", made.components, (Connection("motor", "heat_flow", "rod", "ambient"),))
    with pytest.raises(InputError, match=r"motor\.heat_flow -> rod\.ambient: W does not convert to K"):
        write_ssp(wrong, tmp_path / "out/cell.ssp")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("connections", "sentence"),
    [
        (
            (
                Connection("motor", "heat_flow", "rod", "heat_flow"),
                Connection("motor", "heat_flow", "rod", "heat_flow", 2.0),
            ),
            "motor.heat_flow -> rod.heat_flow: rod.heat_flow is driven by motor.heat_flow already; "
            "one connection may enter an input",
        ),
        (
            (Connection("rod", "temperature", "motor", "link_temperature"),),
            "rod.temperature -> motor.link_temperature: the units differ by a factor 1 and an "
            "offset -273.15; give them to the connection",
        ),
        (
            (Connection("rod", "temperature", "elbow", "ambient"),),
            "rod.temperature -> elbow.ambient: there is no component elbow; "
            "choose motor, arm.link, rod or third, or add it",
        ),
        (
            (Connection("rod", "ambient", "motor", "ambient"),),
            "rod.ambient -> motor.ambient: input does not connect to input; connect an output to an input",
        ),
        (
            (Connection("motor", "steps", "motor", "ambient"),),
            "motor.steps -> motor.ambient: Integer does not convert to Real; connect variables of one type",
        ),
        (
            (Connection("motor", "step", "motor", "ambient"),),
            "motor.step: Motor.fmu has no variable step; did you mean steps?",
        ),
        (
            (Connection("rod", "heat_flow", "motor", "heat_flow"),),
            "rod.heat_flow -> motor.heat_flow: leads from an input to an output; turn it round",
        ),
    ],
)
def test_a_system_made_in_code_is_checked_alike(
    made: System, connections: tuple[Connection, ...], sentence: str
) -> None:
    with pytest.raises(InputError) as refusal:
        check_system(System("cell", made.components, connections))
    assert str(refusal.value) == sentence


@pytest.mark.parametrize(
    ("part", "connector", "sentence"),
    [
        ("rod", "mode", "motor.steps -> rod.mode: rod has no connector mode; declare it"),
        ("rod", "temperature", "ports: rod has no connector temperature; declare it"),
    ],
)
def test_a_connector_that_is_not_declared_is_named_in_a_system_with_ports(
    made: System, tmp_path: Path, part: str, connector: str, sentence: str
) -> None:
    write_ssp(made, tmp_path / "whole.ssp")
    read = read_system(tmp_path / "whole.ssp")
    held = read.components[part]
    left = {name: each for name, each in held.connectors.items() if name != connector}
    cut = replace(read, components={**read.components, part: replace(held, connectors=left)})
    with pytest.raises(InputError) as refusal:
        write_ssp(cut, tmp_path / "open.ssp", Ports(("motor",), (("rod", "temperature"),)))
    assert str(refusal.value) == sentence
    assert not (tmp_path / "open.ssp").exists()


def test_ends_that_are_not_there_are_named(made: System) -> None:
    with pytest.raises(InputError, match=r"^elbow\.x: there is no component of this name"):
        connected(made.components, [("elbow.x", "rod.ambient")])


def test_values_are_checked_when_a_component_is_made(lab: Lab) -> None:
    link = lab.fmu("Link", fmi2("Link", LINK))
    with pytest.raises(InputError, match=r"^link\.length: -0\.02 m is below its minimum; give at least 0 m$"):
        component("link", link, {"length": -0.02})
    with pytest.raises(InputError, match=r"^link\.cells: 2\.5 is not of type Integer"):
        component("link", link, {"cells": 2.5})
    assert component("link", link, {"length": 1}).values == {"length": 1.0}


def test_parameter_sets_round_trip(tmp_path: Path) -> None:
    values = {
        "length": SsvValue("length", "Real", 0.1 + 0.2, parse_unit("mm")),
        "plain": SsvValue("plain", "Real", 1e-300),
        "cells": SsvValue("cells", "Integer", -(2**31)),
        "radiates": SsvValue("radiates", "Boolean", True),
        "label": SsvValue("label", "String", 'ein "Stab" <µ>'),
        "metal": SsvValue("metal", "Enumeration", "brass"),
    }
    write_ssv(values, tmp_path / "rod.ssv")
    assert read_ssv(tmp_path / "rod.ssv") == values
    schema("SystemStructureParameterValues.xsd").assertValid(etree.parse(tmp_path / "rod.ssv"))
    write_ssv({"a": np.float64(1.5), "b": 2, "c": False, "d": "x"}, tmp_path / "plain.ssv")
    read = read_ssv(tmp_path / "plain.ssv")
    assert {k: (p.type, p.value) for k, p in read.items()} == {
        "a": ("Real", 1.5),
        "b": ("Integer", 2),
        "c": ("Boolean", False),
        "d": ("String", "x"),
    }


def test_what_is_no_ssv_is_named(tmp_path: Path) -> None:
    (tmp_path / "x.ssv").write_text(ssd(system()))
    with pytest.raises(InputError, match=r"x\.ssv: its root is SystemStructureDescription"):
        read_ssv(tmp_path / "x.ssv")
    with pytest.raises(InputError, match="no such file"):
        read_ssv(tmp_path / "y.ssv")


def test_a_file_that_cannot_be_written_and_a_version_that_is_none_end_in_a_sentence(
    made: System, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        write_ssp(made, tmp_path)
    with pytest.raises(InputError, match="version=3: no such version; choose 1 or 2"):
        write_ssp(made, tmp_path / "made.ssp", version=3)
    assert [path.name for path in tmp_path.iterdir() if path.suffix == ".ssp"] == []
    for version in ("2.0", 2, 2.0):
        write_ssp(made, tmp_path / f"{version!r}.ssp", version=version)
    assert len({path.read_bytes() for path in tmp_path.glob("*.ssp")}) == 1

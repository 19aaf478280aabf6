"""What other tools need of an SSP: an annotation, no connectors left loose, and ports where it is a part."""

from __future__ import annotations

import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from warmlink.orchestration.arm.chain import arm_chain
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.files import write_machine
from warmlink.orchestration.machine.machine import Machine
from warmlink.orchestration.machine.shipped import WARMUP_CELL, machine_named
from warmlink.orchestration.master.algorithms.explicit import Jacobi
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.write import Ports, write_ssp

from .ssp_text import component, connection, connector, ssd, write_zip
from .ssp_text import system as system_text
from .test_write_system import schema

LAW = controller("lag").name


def built(machine: Machine) -> System:
    files = FmuStore("native").files(set(machine.parts_with(LAW).values()))
    return machine.system(files, LAW, machine.shown)


def structure(path: Path) -> etree._Element:
    with zipfile.ZipFile(path) as archive:
        root = etree.fromstring(archive.read("SystemStructure.ssd"))
    schema("SystemStructureDescription.xsd").assertValid(root)
    return root


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("cell") / "WarmupCell.ssp"
    write_ssp(built(WARMUP_CELL), path)
    return path


@pytest.fixture(scope="module")
def arms(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    arm = arm_chain(2)
    return write_machine(built(arm), arm.ports, tmp_path_factory.mktemp("arm"))


def test_omsimulator_is_told_of_each_system_that_it_is_one_of_co_simulation(
    cell: Path, arms: list[Path]
) -> None:
    for path in (cell, *arms):
        systems = list(structure(path).iter("{*}System"))
        assert len(systems) == (3 if path.name == "Arm2.ssp" else 1)
        for system in systems:
            (note,) = system.findall("{*}Annotations/{*}Annotation[@type='org.openmodelica']")
            (master,) = note.iter("{*}FixedStepMaster")
            # OMSimulator knows elements by their prefix, and reads the first annotation alone.
            assert (master.prefix, master.get("description"), master.get("stepSize")) == (
                "oms",
                "oms-ma",
                "1.0",
            )


def test_inputs_that_nothing_feeds_are_no_connectors(cell: Path, arms: list[Path]) -> None:
    for path in (cell, *arms[1:]):
        root = structure(path)
        fed = {(c.get("endElement"), c.get("endConnector")) for c in root.iter("{*}Connection")}
        listed = {
            (part.get("name"), each.get("name"))
            for part in root.iter("{*}Component")
            for each in part.iter("{*}Connector")
            if each.get("kind") == "input"
        }
        assert listed == {end for end in fed if end[0] is not None}


def test_fmpy_runs_the_cell(cell: Path) -> None:
    """But for its first step, in which it feeds 0 to all inputs."""
    from fmpy.ssp.simulation import simulate_ssp

    theirs = simulate_ssp(str(cell), stop_time=600.0, step_size=1.0)
    ours = simulate(built(WARMUP_CELL), 600.0, 1.0, Jacobi())["link.elongation"][-1]
    assert ours > 1e-5
    assert abs(theirs["link.elongation"][-1] - ours) < 0.03 * ours


def test_a_larger_system_drives_the_cell_through_its_ports(cell: Path, tmp_path: Path) -> None:
    whole = built(WARMUP_CELL)
    write_ssp(whole, tmp_path / "part.ssp", WARMUP_CELL.ports)
    ports = structure(tmp_path / "part.ssp").findall("{*}System/{*}Connectors/{*}Connector")
    given = [c.get("name") for c in ports if c.get("kind") == "input"]
    shown = [c.get("name") for c in ports if c.get("kind") == "output"]
    assert given == ["speed", "torque", "ambient_temperature", "pad_mode", "pad_temperature", "pad_power"]
    assert shown[:3] == ["elongation", "correction", "measured_drift"]
    assert shown[-1] == "reading[8]"

    inputs = "".join(connector(name, "input") for name in given)
    giving = "".join(connector(name, "output") for name in given)
    part = component("part", "resources/part.ssp", inputs, attributes='type="application/x-ssp-package"')
    wires = "".join(connection(f"duty.{name}", f"part.{name}") for name in given)
    outer = ssd(system_text(component("duty", "resources/Duty.fmu", giving) + part, wires))
    files = {
        "SystemStructure.ssd": outer,
        "resources/part.ssp": (tmp_path / "part.ssp").read_bytes(),
        "resources/Duty.fmu": whole.components["duty"].fmu.read_bytes(),
    }
    path = write_zip(tmp_path / "outer.ssp", files)
    held = simulate(read_system(path, tmp_path / "work"), 300.0, 1.0, Jacobi())
    alone = simulate(read_system(cell, tmp_path / "cell"), 300.0, 1.0, Jacobi())
    for name in ("link.elongation", "camera.measured_drift", "compensator.correction"):
        assert np.ptp(alone[name]) > 1e-7
        np.testing.assert_array_equal(held[f"part.{name}"], alone[name])


def test_ports_of_one_name_in_both_directions_stay_apart(tmp_path: Path) -> None:
    ports = Ports(("duty",), (("link", "base_temperature"), ("other", "speed")))
    parts = {**WARMUP_CELL.parts, "other": "DutyCycle"}
    write_ssp(built(replace(WARMUP_CELL, parts=parts)), tmp_path / "part.ssp", ports)
    connectors = structure(tmp_path / "part.ssp").findall("{*}System/{*}Connectors/{*}Connector")
    kinds = {c.get("name"): c.get("kind") for c in connectors}
    assert (kinds["duty_speed"], kinds["other_speed"]) == ("input", "output")
    assert kinds["base_temperature"] == "output"
    read_system(tmp_path / "part.ssp", tmp_path / "work")


def test_an_arm_has_ports_for_duty_angles_and_results(arms: list[Path]) -> None:
    connectors = structure(arms[2]).findall("{*}System/{*}Connectors/{*}Connector")
    names = {c.get("kind"): [] for c in connectors}
    for each in connectors:
        names[each.get("kind")].append(each.get("name"))
    assert {"axis1_duty_speed", "axis2_duty_torque", "angle[2]"} <= set(names["input"])
    assert {"error[1]", "axis2_link_elongation", "axis1_compensator_correction"} <= set(names["output"])
    assert "axis1_sensors_reading[8]" in names["output"]


@pytest.mark.parametrize(
    ("bench", "watched"), [("BenchRod", "link.elongation"), ("BenchMotor", "motor.winding_temperature")]
)
def test_a_bench_does_something_by_itself(bench: str, watched: str, tmp_path: Path) -> None:
    write_ssp(built(machine_named(bench)), tmp_path / "bench.ssp")
    values = simulate(read_system(tmp_path / "bench.ssp", tmp_path / "work"), 60.0, 1.0)[watched]
    assert values[-1] > values[0]

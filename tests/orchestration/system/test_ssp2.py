"""SSP 2.0: arrays as a whole and by index, led through systems, in parameter sets; tables of values."""

# ruff: noqa: E501 - a sentence stands on one line, as its reader sees it

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.referees import ecos
from warmlink.fmus.errors import InputError
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.assemble import assemble, check_system, read_system
from warmlink.orchestration.system.model import Connection, DefaultExperiment, System
from warmlink.orchestration.system.write import PARAMETER_SET, write_ssp

from .ssp_text import (
    Lab,
    alone,
    binding,
    cell,
    component,
    connection,
    connector,
    entry,
    mapping,
    ssd,
    ssv,
    system,
    write_zip,
)

EIGHT = '<ssc:Real unit="K"/><ssc:Dimension size="8"/>'
OFFSETS = [0.1 * n for n in range(8)]


def array(name: str, sizes: tuple[int, ...], values: str, kind: str = "Real") -> str:
    """Give an inline parameter set with one array."""
    dimensions = "".join(f'<ssv:Dimension size="{size}"/>' for size in sizes)
    entry = f'<ssv:Parameter name="{name}"><ssv:{kind} value="{values}"/>{dimensions}</ssv:Parameter>'
    whole = (
        ssv()
        .replace("<ssv:Parameters>", f"<ssv:Parameters>{entry}")
        .replace('version="1.0"', 'version="2.0"')
    )
    return binding(f"<ssd:ParameterValues>{whole}</ssd:ParameterValues>")


def axis(first: str, second: str, sensors: str = "") -> str:
    """Give a link inside the system `axis`, and thermometers outside, with a connection inside and one outside."""
    link = component("link", "resources/Link.fmu", connector("sensor_temperature", "output", EIGHT))
    ports = f"<ssd:Connectors>{connector('rise', 'output', EIGHT)}</ssd:Connectors>"
    inner = system(link, first, "axis", before=ports)
    taking = connector("temperature", "input", EIGHT) + connector("reading", "output", EIGHT)
    outside = component("sensors", "resources/Sensors.fmu", taking, sensors)
    return ssd(system(inner + outside, second), "2.0")


def read(folder: Path, text: str) -> System:
    files = FmuStore("native").files(["ThermalLink", "TemperatureSensors"])
    entries: dict[str, str | bytes] = {
        "SystemStructure.ssd": text,
        "resources/Link.fmu": files["ThermalLink"].read_bytes(),
        "resources/Sensors.fmu": files["TemperatureSensors"].read_bytes(),
    }
    return read_system(write_zip(folder / "axis.ssp", entries), folder / "work")


WHOLE = connection("link.sensor_temperature", "rise"), connection("axis.rise", "sensors.temperature")


def test_arrays_of_scalars_are_led_through_systems(tmp_path: Path) -> None:
    found = read(tmp_path, axis(*WHOLE, array("offset", (8,), " ".join(map(str, OFFSETS)))))
    assert list(found.connections) == [
        Connection("axis.link", f"sensor_temperature[{n}]", "sensors", f"temperature[{n}]")
        for n in range(1, 9)
    ]
    assert found.components["sensors"].values == {f"offset[{n}]": v for n, v in enumerate(OFFSETS, start=1)}
    assert not found.remarks


def heated(found: System) -> System:
    """Give the system with heat into its link."""
    found.components["axis.link"].values["heat_flow"] = 5.0
    return System(found.name, found.components, found.connections, DefaultExperiment(0.0, 5.0, 1.0))


def test_it_runs_as_with_scalars(tmp_path: Path) -> None:
    found = heated(read(tmp_path, axis(*WHOLE, array("offset", (8,), " ".join(map(str, OFFSETS))))))
    files = FmuStore("native").files(["ThermalLink", "TemperatureSensors"])
    parts = {"axis.link": files["ThermalLink"], "sensors": files["TemperatureSensors"]}
    wires = [(f"axis.link.sensor_temperature[{n}]", f"sensors.temperature[{n}]") for n in range(1, 9)]
    given = {"sensors": dict(found.components["sensors"].values), "axis.link": {"heat_flow": 5.0}}
    scalars = assemble("scalars", parts, wires, given)
    one, other = (simulate(each, 5.0, 1.0) for each in (found, scalars))
    assert np.ptp(one["sensors.reading[1]"]) > 0
    for name in (f"sensors.reading[{n}]" for n in range(1, 9)):
        np.testing.assert_array_equal(one[name], other[name])


@pytest.mark.platform
def test_flat_it_is_what_ecos_runs(tmp_path: Path) -> None:
    """The nested system with arrays, written flat with scalars."""
    found = heated(read(tmp_path, axis(*WHOLE, array("offset", (8,), " ".join(map(str, OFFSETS))))))
    parts = {name.replace(".", "_"): held for name, held in found.components.items()}
    flat = System(
        "flat",
        {name: type(held)(name, held.fmu, held.connectors, held.values) for name, held in parts.items()},
        tuple(Connection("axis_link", c.source_variable, *c.ends[1]) for c in found.connections),
        found.default_experiment,
    )
    write_ssp(flat, tmp_path / "flat.ssp")
    ours = simulate(flat, 5.0, 1.0)
    theirs = ecos(
        tmp_path / "flat.ssp", 5, 1.0, PARAMETER_SET, (("sensors.reading[1]", 0), ("sensors.reading[2]", 0))
    )
    for n in (1, 2):
        np.testing.assert_allclose(
            [row[n - 1] for row in theirs], ours[f"sensors.reading[{n}]"][1:], rtol=1e-12
        )


def test_elements_are_connected_by_index(tmp_path: Path) -> None:
    inner = connection("link.sensor_temperature", "rise", attributes='startIndices="3" endIndices="1"')
    outer = connection("axis.rise", "sensors.temperature", attributes='startIndices="1" endIndices="2"')
    assert read(tmp_path, axis(inner, outer)).connections == (
        Connection("axis.link", "sensor_temperature[3]", "sensors", "temperature[2]"),
    )


def test_an_array_is_mapped_element_by_element(tmp_path: Path) -> None:
    bound = array("zero_errors", (8,), "1 2 3 4 5 6 7 8").replace(
        "</ssd:ParameterBinding>", mapping(entry("zero_errors", "offset")) + "</ssd:ParameterBinding>"
    )
    values = read(tmp_path, axis(*WHOLE, bound)).components["sensors"].values
    assert values == {f"offset[{n}]": float(n) for n in range(1, 9)}


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            axis(*WHOLE, array("offset", (8,), "1 2 3")),
            "sensors: ParameterSet: offset: has 3 values for 8 elements; give one for each",
        ),
        (
            axis(WHOLE[0], connection("axis.rise", "sensors.temperature", attributes='endIndices="9"')),
            "axis.rise -> sensors.temperature[9]: 8 and 1 elements; connect arrays of one size, or give startIndices or endIndices",
        ),
        (
            axis(
                WHOLE[0],
                connection("axis.rise", "sensors.temperature", attributes='startIndices="1" endIndices="9"'),
            ),
            "axis.rise[1] -> sensors.temperature[9]: sensors has no connector temperature[9]; declare it or correct the name",
        ),
        (
            axis(*WHOLE).replace('size="8"', 'size="7"'),
            "axis.link.sensor_temperature: is declared with 7 elements, but has 8 in its FMU; correct one",
        ),
        (
            axis(WHOLE[0], connection("axis.rise", "sensors.temperature", attributes='endIndices="one"')),
            "axis.ssp: temperature: endIndices: 'one' is not an integer",
        ),
    ],
    ids=["values", "one_end", "absent", "size", "no_number"],
)
def test_what_does_not_fit_is_refused_in_one_sentence(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(InputError, match=re.escape(sentence.removeprefix("axis.ssp: "))):
        read(tmp_path, text)


def table(kind: str, *entries: tuple[str, str]) -> str:
    inside = "".join(f'<ssc:MapEntry source="{a}" target="{b}"/>' for a, b in entries)
    return f"<ssc:{kind}MappingTransformation>{inside}</ssc:{kind}MappingTransformation>"


def test_tables_of_values_change_connections_and_parameters(lab: Lab) -> None:
    linked = lab.read(cell(connection("motor.steps", "link.mode", table("Integer", ("0", "2"), ("7", "7")))))
    assert linked.connections == (Connection("motor", "steps", "link", "mode", values=((0, 2),)),)
    turned = mapping(
        entry("on", "radiates", table("Boolean", ("true", "false"), ("false", "true")))
        + entry("stuff", "metal", table("Enumeration", ("steel", "brass")))
    )
    bound = binding(
        f"<ssd:ParameterValues>{ssv('on:Boolean:false', 'stuff:Enumeration:steel')}</ssd:ParameterValues>{turned}"
    )
    assert lab.read(alone(bindings=bound)).components["link"].values == {"radiates": True, "metal": 2}


def test_a_table_that_leaves_a_value_as_it_is_fits_and_one_that_contradicts_itself_does_not(lab: Lab) -> None:
    """Units were blamed for both, "by a factor 1 and an offset 0"."""
    system = lab.read(cell(connection("motor.steps", "link.mode")))
    (plain,) = system.connections
    check_system(replace(system, connections=(replace(plain, values=((0, 2), (7, 7))),)))
    twice = replace(system, connections=(replace(plain, values=((0, 2), (0, 1))),))
    with pytest.raises(InputError, match=r"motor\.steps -> link\.mode: one value becomes two others"):
        check_system(twice)


def test_a_table_is_written_read_and_obeyed(tmp_path: Path) -> None:
    """A pad whose mode 0 means 2, off in the duty cycle, holds its temperature."""
    files = FmuStore("native").files(["DutyCycle", "MotorHeatSource"])
    parts = {"duty": files["DutyCycle"], "motor": files["MotorHeatSource"]}
    given = {"motor": {"pad_temperature": 320.0}}
    wired = assemble("pad", parts, [("duty.pad_mode", "motor.pad_mode")], given)
    (link,) = wired.connections
    changed = Connection(*link.ends[0], *link.ends[1], values=((0, 2),))
    write_ssp(System("pad", wired.components, (changed,)), tmp_path / "pad.ssp")
    again = read_system(tmp_path / "pad.ssp", tmp_path / "work")
    assert again.connections == (changed,)
    warm, cold = (
        simulate(each, 60.0, 1.0, stepping=how)["motor.shaft_temperature"]
        for each, how in ((again, "preferred"), (wired, "plain"))
    )
    plain = assemble(
        "pad", {"motor": parts["motor"]}, (), {"motor": {"pad_temperature": 320.0, "pad_mode": 2}}
    )
    np.testing.assert_array_equal(warm, simulate(plain, 60.0, 1.0)["motor.shaft_temperature"])
    assert warm[-1] > cold[-1] + 1

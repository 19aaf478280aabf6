"""A system as a part of a larger one: what drives it comes through its ports, and nothing is lost."""

from __future__ import annotations

from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.assemble import component, connected, read_system
from warmlink.orchestration.system.model import Connection, System
from warmlink.orchestration.system.ports import End, Ports
from warmlink.orchestration.system.write import write_ssp

from .ssp_text import LINK, METAL, Lab, connection, fmi2, fmi2_variable, ssd, write_zip
from .ssp_text import component as component_text
from .ssp_text import connector as connector_text
from .ssp_text import system as system_text
from .test_other_tools import structure


def source(lab: Lab, name: str, unit: str) -> Path:
    return lab.fmu(name, fmi2(name, (fmi2_variable("t", "output", attributes=f'unit="{unit}"'),)))


@pytest.fixture
def made(lab: Lab) -> System:
    """Surroundings in degC, and two links in K, of which they drive one."""
    link = lab.fmu("Link", fmi2("Link", LINK))
    parts = {
        "room": component("room", source(lab, "Room", "degC")),
        "rod": component("rod", link),
        "beam": component("beam", link),
    }
    return System("cell", parts, tuple(connected(parts, [("room.t", "rod.ambient")])))


def within(lab: Lab, part: Path, unit: str) -> tuple[Connection, ...]:
    """Connections of a larger system, in which a source in a unit drives the part."""
    port = connector_text("t", "input")
    outer = component_text("other", "resources/Other.fmu", connector_text("t", "output"))
    outer += component_text("part", "resources/part.ssp", port, attributes='type="application/x-ssp-package"')
    files = {
        "SystemStructure.ssd": ssd(system_text(outer, connection("other.t", "part.t"))),
        "resources/part.ssp": part.read_bytes(),
        "resources/Other.fmu": source(lab, "Other", unit).read_bytes(),
    }
    return read_system(write_zip(lab.folder / "outer.ssp", files), lab.folder / f"work-{unit}").connections


@pytest.mark.parametrize(("unit", "offset"), [("K", 0.0), ("degC", 273.15)])
def test_a_port_is_in_the_unit_of_what_it_takes_the_place_of(
    unit: str, offset: float, made: System, lab: Lab, tmp_path: Path
) -> None:
    """It was in that of its target, and the conversion from the driver's came on top."""
    write_ssp(made, tmp_path / "part.ssp", Ports(("room",), (("rod", "temperature"),)))
    (link,) = within(lab, tmp_path / "part.ssp", unit)
    assert (link.factor, link.offset) == (1.0, pytest.approx(offset))


def test_what_a_connection_does_to_a_value_is_kept(made: System, lab: Lab, tmp_path: Path) -> None:
    """One in degC doubled on its way; one in K is converted to degC first."""
    doubled = System("cell", made.components, (Connection("room", "t", "rod", "ambient", 2.0, 300.0),))
    write_ssp(doubled, tmp_path / "part.ssp", Ports(("room",), ()))
    for unit, offset in (("degC", 300.0), ("K", 300.0 - 2 * 273.15)):
        (link,) = within(lab, tmp_path / "part.ssp", unit)
        assert (link.factor, link.offset) == (2.0, pytest.approx(offset))


@pytest.mark.parametrize(
    ("drivers", "shown", "sentence"),
    [
        (("rom",), (), "ports: there is no component rom to be left out; did you mean room?"),
        (("room",), (("bar", "temperature"),), "ports: no component bar is left to be shown; choose"),
        (("room",), (("room", "t"),), "ports: no component room is left to be shown; choose"),
        (("rod",), (), "ports: room.t drives rod.ambient, which is left out; leave out both or neither"),
    ],
)
def test_ports_that_do_not_fit_are_named(
    drivers: tuple[str, ...], shown: tuple[End, ...], sentence: str, made: System, tmp_path: Path
) -> None:
    with pytest.raises(InputError) as refusal:
        write_ssp(made, tmp_path / "part.ssp", Ports(drivers, shown))
    assert str(refusal.value).startswith(sentence)
    assert not (tmp_path / "part.ssp").exists()


def test_drivers_of_drivers_are_left_out_with_them(made: System, tmp_path: Path) -> None:
    write_ssp(made, tmp_path / "part.ssp", Ports(("room", "rod"), (("beam", "temperature"),)))
    assert list(read_system(tmp_path / "part.ssp", tmp_path / "work").components) == ["beam"]


def test_a_nested_system_has_no_ports(made: System, tmp_path: Path) -> None:
    """It was written flat, without a word."""
    with pytest.raises(InputError, match=r"^ports: a nested system has none; leave one out$"):
        write_ssp(made, tmp_path / "part.ssp", Ports(("room",), ()), nested=True)


def test_no_port_takes_the_name_of_another(lab: Lab, tmp_path: Path) -> None:
    names = ("y", "a_y")
    fmu = lab.fmu("Three", fmi2("Three", tuple(fmi2_variable(name, "output") for name in names)))
    whole = System("cell", {name: component(name, fmu) for name in "abc"})
    shown = (("a", "y"), ("b", "y"), ("c", "a_y"))
    write_ssp(whole, tmp_path / "part.ssp", Ports((), shown))
    ports = structure(tmp_path / "part.ssp").findall("{*}System/{*}Connectors/{*}Connector")
    assert sorted(str(each.get("name")) for each in ports) == ["a_y", "a_y_", "b_y"]


def test_fmus_of_one_name_keep_their_own_enumerations(lab: Lab, tmp_path: Path) -> None:
    """The items of the second stood for both."""
    parts = {}
    for name, items in (("old", METAL), ("new", METAL.replace('name="steel"', 'name="zinc"'))):
        text = fmi2("Link", LINK).replace(METAL, items)
        fmu = write_zip(lab.folder / name / "Link.fmu", {"modelDescription.xml": text})
        parts[name] = component(name, fmu, {"metal": 1})
    write_ssp(System("cell", parts), tmp_path / "cell.ssp")
    root = structure(tmp_path / "cell.ssp")
    items = {
        each.get("name"): [item.get("name") for item in each]
        for each in root.findall("{*}Enumerations/{*}Enumeration")
    }
    for part, metals in (("old", ["steel", "brass"]), ("new", ["zinc", "brass"])):
        (held,) = (each for each in root.iter("{*}Component") if each.get("name") == part)
        (named,) = held.iter("{*}Enumeration")
        assert items[named.get("name")] == metals

"""What other tools write against the standard is read, with a remark, where its meaning is plain."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

from tests.shared_data import given
from warmlink.fmus.errors import InputError
from warmlink.orchestration.scenarios.overrides import parameters_of
from warmlink.orchestration.simulation import simulate
from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.written.quantities import quantity

from .ssp_text import (
    LINK_CONNECTORS,
    NAMESPACES,
    Lab,
    binding,
    component,
    connection,
    connector,
    entry,
    fmi2,
    fmi2_variable,
    mapping,
    parameters,
    ssd,
    ssv,
    system,
)

LENGTH = "link: ParameterSet: "


def alone(connectors: str = "", bindings: str = "") -> str:
    return ssd(system(component("link", "resources/Link.fmu", connectors, bindings)))


def test_a_connector_that_is_no_variable_is_left_out(lab: Lab) -> None:
    read = lab.read(alone(connector("_u_start", "parameter") + connector("ambient", "input")))
    assert list(read.components["link"].connectors) == ["ambient"]
    told = "link._u_start: declared as a connector, but no variable of Link.fmu; it is left out"
    assert read.remarks == (told,)


def test_an_empty_element_of_a_connection_is_the_system(lab: Lab) -> None:
    driven = connection("heat", "link.heat_flow", attributes='startElement=""')
    start = f"<ssd:ParameterBindings>{parameters('heat:Real:5:W')}</ssd:ParameterBindings>"
    before = f"<ssd:Connectors>{connector('heat', 'input')}</ssd:Connectors>{start}"
    read = lab.read(
        ssd(system(component("link", "resources/Link.fmu", LINK_CONNECTORS), driven, before=before))
    )
    assert read.components["link"].values == {"heat_flow": 5.0}
    told = "heat -> link.heat_flow: its startElement is empty and is read as the system itself"
    assert read.remarks == (told,)


def test_a_prefix_that_is_not_declared_has_the_standards_meaning(lab: Lab) -> None:
    note = (
        '<ssd:Annotations><ssc:Annotation type="x"><osp:A><osp:B/></osp:A></ssc:Annotation></ssd:Annotations>'
    )
    (remark,) = lab.read(ssd(system(component("link", "resources/Link.fmu")), after=note)).remarks
    assert remark.startswith("SystemStructure.ssd: the prefix osp is not declared (from line 1 on)")
    bare = ssv("length:Real:2").replace(NAMESPACES, "")
    read = lab.read(alone("", binding(attributes='source="p.ssv"')), {"p.ssv": bare})
    assert read.components["link"].values == {"length": 2.0}
    (remark,) = read.remarks
    assert remark.startswith("link: p.ssv: the prefix ssv, ssc is not declared")


def test_what_is_wrong_beside_a_prefix_is_refused(lab: Lab) -> None:
    with pytest.raises(InputError, match="not well-formed XML"):
        lab.read(ssd(system(component("link", "resources/Link.fmu")), after="<osp:A><osp:B></osp:A>"))


def test_an_undeclared_prefix_declares_no_entity(lab: Lab) -> None:
    text = '<!DOCTYPE a [<!ENTITY e "x">]><osp:A>&e;</osp:A>'
    with pytest.raises(InputError, match="declares a document type"):
        lab.read(text)


@pytest.mark.parametrize(
    ("space", "told"),
    [
        (' xmlns="http://ssp-standard.org/SSP1/ParameterValues"', "'http://ssp-standard.org/SSP1/ParameterV"),
        ("", "in no namespace"),
    ],
)
def test_a_parameter_set_in_another_namespace_is_read(lab: Lab, space: str, told: str) -> None:
    text = (
        f'<ParameterSet{space} version="1.0" name="p"><Parameters><Parameter name="length">'
        '<Real value="330" unit="mm"/></Parameter></Parameters></ParameterSet>'
    )
    read = lab.read(alone("", binding(attributes='source="p.ssv"')), {"p.ssv": text})
    assert read.components["link"].values == {"length": 0.33}
    (remark,) = read.remarks
    assert remark.startswith("link: p.ssv: ParameterSet is in ")
    assert told in remark


def test_units_in_brackets_are_read_and_remarked_upon_once(lab: Lab) -> None:
    values = parameters("length:Real:330:[mm]", "difference:Real:5:[degC]", "heat_flow:Real:1:[W]")
    read = lab.read(alone(connector("ambient", "input", '<ssc:Real unit="[K]"/>'), values))
    assert read.components["link"].values == {"length": 0.33, "difference": 5.0, "heat_flow": 1.0}
    assert read.remarks == (
        "link.ambient: the unit [K] is read as K throughout",
        f"{LENGTH}length: the unit [mm] is read as mm throughout",
        f"{LENGTH}difference: the unit [degC] is read as degC throughout",
        f"{LENGTH}heat_flow: the unit [W] is read as W throughout",
    )
    twice = lab.read(lab.cell(link=parameters("length:Real:1:[m]", "heat_flow:Real:1:W", "label:String:[m]")))
    assert len(twice.remarks) == 1


def test_a_dash_is_no_unit_beside_a_unit_and_a_number_beside_none(lab: Lab) -> None:
    read = lab.read(
        alone(connector("ambient", "input", '<ssc:Real unit="-"/>'), parameters("length:Real:2:-"))
    )
    assert read.components["link"].values == {"length": 2.0}
    assert (
        read.components["link"].connectors["ambient"].unit
        == read_description(read.components["link"].fmu).units["K"]
    )
    assert read.remarks == (
        "link.ambient: the unit - is read as none, beside K",
        "link.length: the unit - is read as none, beside m",
    )
    plain = (
        fmi2_variable("gain", "parameter", attributes='unit="1" start="1"', outer='variability="fixed"'),
    )
    fmu = lab.fmu("Plain", fmi2("Plain", plain)).read_bytes()
    text = ssd(system(component("plain", "resources/Plain.fmu", "", parameters("gain:Real:2:-"))))
    assert lab.read(text, {"resources/Plain.fmu": fmu}).remarks == ()


def test_a_connection_between_a_unit_and_a_dash_is_not_converted(lab: Lab) -> None:
    giving = (fmi2_variable("flow", "output", attributes='unit="-"'),)
    fmu = lab.fmu("Giving", fmi2("Giving", giving)).read_bytes()
    elements = component("giving", "resources/Giving.fmu", connector("flow", "output"))
    elements += component("link", "resources/Link.fmu", LINK_CONNECTORS)
    text = ssd(system(elements, connection("giving.flow", "link.heat_flow")))
    read = lab.read(text, {"resources/Giving.fmu": fmu})
    assert [(each.factor, each.offset) for each in read.connections] == [(1.0, 0.0)]
    assert read.remarks == ("giving.flow -> link.heat_flow: the unit - is read as none, beside W",)


def test_equal_values_may_stand_twice(lab: Lab) -> None:
    read = lab.read(alone("", parameters("length:Real:2:m", "length:Real:2:m")))
    assert read.components["link"].values == {"length": 2.0}
    assert read.remarks == (f"{LENGTH}gives the parameter length twice, with the same value",)
    for other in ("length:Real:2:mm", "length:Real:3:m"):
        with pytest.raises(InputError, match="gives the parameter length twice; keep one"):
            lab.read(alone("", parameters("length:Real:2:m", other)))


def test_an_fmu_behind_a_proxy_on_this_computer_is_run_without_it(lab: Lab) -> None:
    """As demos of the Open Simulation Platform name theirs."""
    source = "proxyfmu://localhost?file=resources/Link.fmu"
    read = lab.read(ssd(system(component("link", source))))
    assert read.remarks == (f"link: source {source} asks for a proxy; the FMU is run without one",)
    with pytest.raises(InputError, match="is not a file inside the SSP"):
        lab.read(ssd(system(component("link", source.replace("localhost", "example.org")))))


def test_values_that_contradict_each_other_may_go_nowhere(lab: Lab) -> None:
    """As those of a whole aircraft's parts in one set, of which a simulation takes some."""
    read = lab.read(alone("", parameters("wing:Real:2:m", "wing:Real:3:m", "length:Real:2:m")))
    assert read.components["link"].values == {"length": 2.0}
    assert any("wing is the name of no variable" in told for told in read.remarks)


def test_a_mapping_to_a_name_that_is_none_has_no_effect(lab: Lab) -> None:
    """As a value of such a name has none."""
    held = parameters("L:Real:1").replace(
        "</ssd:ParameterBinding>", mapping(entry("L", "lenght")) + "</ssd:ParameterBinding>"
    )
    read = lab.read(alone("", held))
    assert read.components["link"].values == {}
    told = "lenght, to which its mapping leads, is the name of no variable and has no effect"
    assert read.remarks == (LENGTH + told,)


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_entries_that_stand_twice_are_remarked_upon_once(lab: Lab) -> None:
    fmu = lab.fmu("Twice", fmi2("Twice", ()))
    with zipfile.ZipFile(fmu, "a") as archive:
        archive.writestr("documentation/a.txt", "1")
        archive.writestr("documentation/a.txt", "1")
    parts = "".join(component(name, "resources/Twice.fmu") for name in ("one", "other"))
    path = lab.ssp(ssd(system(parts)), {"resources/Twice.fmu": fmu.read_bytes(), "a": "1"})
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("a", "2")
    told = [
        f"{path.name}: holds 'a' twice; the last one counts",
        "Twice.fmu: holds 'documentation/a.txt' twice; the last one counts",
    ]
    # The second time both are unpacked already.
    assert [read_system(path, lab.folder / "work").remarks for _ in range(2)] == [tuple(told)] * 2


def test_an_fmus_undeclared_prefix_is_remarked_upon_with_its_file(lab: Lab) -> None:
    text = fmi2("Odd", ()).replace(
        "<ModelVariables>", "<VendorAnnotations><x:A/></VendorAnnotations><ModelVariables>"
    )
    for name in ("Odd", "Even"):  # the second one is remembered
        (told,) = read_description(lab.fmu(name, text)).remarks
        assert told.startswith(f"{name}.fmu: modelDescription.xml: the prefix x is not declared")


@pytest.mark.parametrize(("unit", "value"), [("mm", 0.33), ("[mm]", 0.33), ("-", 330.0)])
def test_a_parameter_file_that_only_names_its_units_is_converted_too(
    tmp_path: Path, unit: str, value: float, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"{len(unit)}.ssv"
    path.write_text(ssv(f"link.length:Real:330:{unit}").partition("<ssv:Units>")[0] + "</ssv:ParameterSet>")
    for _ in range(2):
        (length,) = parameters_of(path).values()
        assert quantity(length, "m") == pytest.approx(value)
    assert capsys.readouterr().err.count("is read as mm") == ("[" in unit)


@pytest.mark.parametrize(
    ("name", "last", "remarks"),
    [
        ("dangling_connector/s.ssp", {"g.y": 0.0}, 1),
        ("OMS495_empty_element/s.ssp", {"r.y": 1.0}, 3),
        ("undeclared_prefix/s.ssp", {"g.y": 0.0}, 1),
        ("ssv_namespace/s.ssp", {"g.y": 3.0}, 1),
        ("ssv_units_and_duplicates/brackets.ssp", {"c.y": 2.0}, 1),
        ("ssv_units_and_duplicates/dash.ssp", {"c.y": 2.0}, 1),
        ("ssv_units_and_duplicates/dup.ssp", {"c.y": 2.0}, 1),
        ("names/s.ssp", {"c d.ä.ö": 5.0, "c d.y;z": 6.0}, 0),
        ("FMPy236_resources/s.ssp", {"c.ok": 1.0}, 0),
        ("FMPy236_resources/doc.ssp", {"c.ok": 0.0}, 0),
    ],
)
def test_strangers_systems_run(
    name: str, last: dict[str, float], remarks: int, capsys: pytest.CaptureFixture[str]
) -> None:
    found = simulate(given("systems_that_fail") / name, step=0.1)
    assert {each: found[each][-1] for each in last} == last
    assert capsys.readouterr().err.count("warmlink: ") == remarks

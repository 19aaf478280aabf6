"""Reading SSPs: what becomes of connections, nesting, units, transformations and start values."""

from __future__ import annotations

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.model import Connection, DefaultExperiment
from warmlink.orchestration.system.units import Unit, parse_unit

from .ssp_text import (
    LINEAR,
    LINK,
    LINK_CONNECTORS,
    MOTOR_CONNECTORS,
    Lab,
    binding,
    component,
    connection,
    connector,
    entry,
    fmi2,
    mapping,
    parameters,
    ssd,
    ssm,
    ssv,
    system,
)
from .test_description import FMI3


def test_components_come_in_order_with_connectors_units_and_files(lab: Lab) -> None:
    read = lab.read(lab.cell(connection("motor.heat_flow", "link.heat_flow")))
    assert list(read.components) == ["motor", "link"]
    assert read.components["link"].fmu.is_file()
    shown = read.components["motor"].connectors.items()
    named = {name: (c.kind, c.type, c.unit and c.unit.name) for name, c in shown}
    assert named["link_temperature"] == ("input", "Real", "degC")
    # The SSD gives neither type nor unit here: both are the FMU's.
    assert named["shaft_temperature"] == ("output", "Real", "K")
    assert named["steps"] == ("output", "Integer", None)
    assert read.connections == (Connection("motor", "heat_flow", "link", "heat_flow"),)
    assert read.remarks == ()


def test_units_of_a_connection_are_converted(lab: Lab) -> None:
    read = lab.read(lab.cell(connection("link.temperature", "motor.link_temperature")))
    (link,) = read.connections
    assert link.factor * 300.0 + link.offset == pytest.approx(26.85, abs=1e-12)


def test_the_direction_is_that_of_the_connectors_not_of_start_and_end(lab: Lab) -> None:
    read = lab.read(lab.cell(connection("link.heat_flow", "motor.heat_flow")))
    assert read.connections == (Connection("motor", "heat_flow", "link", "heat_flow"),)


def test_a_difference_keeps_its_size_without_the_zero_of_the_scale(lab: Lab) -> None:
    read = lab.read(lab.cell(connection("motor.rise", "link.difference")))
    assert read.connections == (Connection("motor", "rise", "link", "difference"),)


def test_a_linear_transformation_follows_the_unit_conversion(lab: Lab) -> None:
    read = lab.read(lab.cell(connection("link.temperature", "motor.link_temperature", LINEAR)))
    (link,) = read.connections
    assert link.factor * 300.0 + link.offset == pytest.approx(2 * 26.85 + 1, abs=1e-12)


def test_a_linear_transformation_may_replace_the_unit_conversion(lab: Lab) -> None:
    suppressed = 'suppressUnitConversion="true"'
    read = lab.read(lab.cell(connection("motor.heat_flow", "link.ambient", LINEAR, suppressed)))
    assert read.connections == (Connection("motor", "heat_flow", "link", "ambient", 2.0, 1.0),)


def test_connectors_may_tell_another_unit_than_their_fmus(lab: Lab) -> None:
    connectors = LINK_CONNECTORS.replace(
        'name="temperature" kind="output"><ssc:Real unit="K"/>',
        ('name="temperature" kind="output"><ssc:Real unit="degC"/>'),
    )
    elements = component("motor", "resources/Motor.fmu", MOTOR_CONNECTORS)
    elements += component("link", "resources/Link.fmu", connectors)
    # The transformation acts on what the connectors show: degC, and then K again inside the FMU.
    inside = connection("link.temperature", "motor.ambient", LINEAR, 'suppressUnitConversion="true"')
    (link,) = lab.read(ssd(system(elements, inside))).connections
    assert link.factor * 300.0 + link.offset == pytest.approx(2 * 26.85 + 1, abs=1e-12)


def test_an_unconnected_input_keeps_its_start_value(lab: Lab) -> None:
    read = lab.read(lab.cell())
    assert read.connections == ()
    assert read.components["motor"].values == {}


def test_the_default_experiment_with_the_step_size_that_libcosim_writes(lab: Lab) -> None:
    osp = (
        '<ssd:Annotations><ssc:Annotation type="com.opensimulationplatform">'
        '<osp:Algorithm xmlns:osp="http://opensimulationplatform.com/SSP/OSPAnnotations">'
        '<osp:FixedStepAlgorithm baseStepSize="0.5"/></osp:Algorithm></ssc:Annotation></ssd:Annotations>'
    )
    after = f'<ssd:DefaultExperiment startTime="1" stopTime="7200">{osp}</ssd:DefaultExperiment>'
    text = ssd(system(component("link", "resources/Link.fmu")), after=after)
    assert lab.read(text).default_experiment == DefaultExperiment(1.0, 7200.0, 0.5)
    assert lab.read(lab.cell()).default_experiment == DefaultExperiment(0.0, None, None)


def test_start_values_of_every_type_in_the_variables_own_units(lab: Lab) -> None:
    given = parameters(
        "length:Real:304.8:mm",
        "ambient:Real:25:degC",
        "cells:Integer:80",
        "radiates:Boolean:true",
        "label:String:rod",
        "metal:Enumeration:brass",
    )
    values = lab.read(lab.cell(link=given)).components["link"].values
    assert values == {
        "length": pytest.approx(0.3048, rel=1e-15),
        "ambient": pytest.approx(298.15, rel=1e-15),
        "cells": 80,
        "radiates": True,
        "label": "rod",
        "metal": 2,
    }


def test_an_enumeration_takes_its_integer_too(lab: Lab) -> None:
    read = lab.read(lab.cell(link=parameters("metal:Integer:2")))
    assert read.components["link"].values == {"metal": 2}
    with pytest.raises(InputError, match=r"brass. is not of type Integer"):
        lab.read(lab.cell(link=parameters("cells:Enumeration:brass")))


def test_parameter_files_beside_the_ssd(lab: Lab) -> None:
    bound = binding(
        '<ssd:ParameterMapping source="resources/names.ssm"/>', 'source="resources/values%20of%20rod.ssv"'
    )
    more: dict[str, str | bytes] = {
        "resources/values of rod.ssv": ssv("L:Real:30:mm", "unused:Real:1"),
        "resources/names.ssm": ssm(entry("L", "length", '<ssc:LinearTransformation factor="10"/>')),
    }
    read = lab.read(lab.cell(link=bound), more)
    assert read.components["link"].values == {"length": pytest.approx(0.3, rel=1e-15)}


def test_a_file_may_be_named_as_a_uri_or_as_it_is(lab: Lab) -> None:
    odd = lab.entries()["resources/Link.fmu"]
    for source, name in (("a%20b.fmu", "a b.fmu"), ("a%20b.fmu", "a%20b.fmu"), ("a b.fmu", "a b.fmu")):
        assert list(lab.read(ssd(system(component("link", source))), {name: odd}).components) == ["link"]


def test_a_mapping_may_suppress_the_unit_conversion(lab: Lab) -> None:
    shift = '<ssc:LinearTransformation factor="0.001" offset="0.5"/>'
    inner = parameters("L:Real:30:mm").replace(
        "</ssd:ParameterValues>",
        "</ssd:ParameterValues>" + mapping(entry("L", "length", shift, 'suppressUnitConversion="true"')),
    )
    assert lab.read(lab.cell(link=inner)).components["link"].values == {"length": 0.53}


def test_later_bindings_win_and_the_system_wins_over_its_components(lab: Lab) -> None:
    link = parameters("length:Real:1", "cells:Integer:10") + parameters("length:Real:2")
    before = f"<ssd:ParameterBindings>{parameters('link.cells:Integer:20')}</ssd:ParameterBindings>"
    values = lab.read(lab.cell(link=link, before=before)).components["link"].values
    assert values == {"length": 2.0, "cells": 20}


def test_a_prefix_makes_a_components_set_fit_the_system(lab: Lab) -> None:
    bound = parameters("length:Real:1").replace(
        "<ssd:ParameterBinding ", '<ssd:ParameterBinding prefix="link." '
    )
    before = f"<ssd:ParameterBindings>{bound}</ssd:ParameterBindings>"
    assert lab.read(lab.cell(before=before)).components["link"].values == {"length": 1.0}


def test_a_value_that_no_variable_bears_is_passed_over_but_told(lab: Lab) -> None:
    read = lab.read(lab.cell(link=parameters("lenght:Real:1")))
    assert read.remarks == ("link: ParameterSet: lenght is the name of no variable and has no effect",)


def test_ssp_two_has_types_of_its_own(lab: Lab) -> None:
    connectors = LINK_CONNECTORS.replace('<ssc:Real unit="W"/>', '<ssc:Float64 unit="W"/>')
    elements = component("motor", "resources/Motor.fmu", MOTOR_CONNECTORS)
    elements += component("link", "resources/Link.fmu", connectors, parameters("length:Float64:1:m"))
    # An FMU of FMI 2.0 calls the same thing Real.
    text = ssd(system(elements, connection("motor.heat_flow", "link.heat_flow")), version="2.0")
    read = lab.read(text)
    assert read.components["link"].values == {"length": 1.0}
    assert read.connections == (Connection("motor", "heat_flow", "link", "heat_flow"),)


def test_an_ssd_beside_its_resources_needs_no_packing(lab: Lab) -> None:
    for name, data in lab.entries().items():
        path = lab.folder / "open" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
    path = lab.folder / "open" / "SystemStructure.ssd"
    path.write_text(lab.cell(connection("motor.heat_flow", "link.heat_flow")))
    assert list(read_system(path, lab.folder / "work").components) == ["motor", "link"]


def test_reading_twice_gives_the_same_and_unpacks_once(lab: Lab) -> None:
    path = lab.ssp(lab.cell(connection("motor.heat_flow", "link.heat_flow")))
    first = read_system(path, lab.folder / "work")
    assert read_system(path, lab.folder / "work") == first
    assert len(list((lab.folder / "work").iterdir())) == 1


def test_an_fmu_without_units_takes_those_of_the_ssd(lab: Lab) -> None:
    bare = fmi2("Bare", tuple(v.replace('unit="m"', "").replace('unit="K"', "") for v in LINK))
    lab.fmu("Bare", bare)
    connectors = connector("ambient", "input", '<ssc:Real unit="degC"/>')
    elements = component("bare", "resources/Bare.fmu", connectors)
    elements += component("link", "resources/Link.fmu", LINK_CONNECTORS)
    text = ssd(system(elements, connection("link.temperature", "bare.ambient")))
    read = lab.read(text, {"resources/Bare.fmu": (lab.folder / "Bare.fmu").read_bytes()})
    (link,) = read.connections
    assert link.factor * 300.0 + link.offset == pytest.approx(26.85, abs=1e-12)
    unit = read.components["bare"].connectors["ambient"].unit
    assert unit == Unit("degC", parse_unit("K").exponents, 1.0, 273.15)


def test_components_of_fmi_three_and_two_mix(lab: Lab) -> None:
    connectors = connector("ambient", "input", '<ssc:Float64 unit="K"/>') + connector("temperature", "output")
    third = component("third", "resources/Link3.fmu", connectors, parameters("cells:UInt8:10"))
    text = ssd(
        system(
            third + component("link", "resources/Link.fmu", LINK_CONNECTORS),
            connection("link.temperature", "third.ambient") + connection("third.temperature", "link.ambient"),
        ),
        version="2.0",
    )
    read = lab.read(text, {"resources/Link3.fmu": lab.fmu("Link3", FMI3).read_bytes()})
    assert [link.target for link in read.connections] == ["third.ambient", "link.ambient"]
    assert read.components["third"].values == {"cells": 10}


@pytest.mark.parametrize(
    ("connected", "sentence"),
    [
        (
            connector("field", "input", '<ssc:Float64/><ssc:Dimension size="2"/>'),
            "third.field: is declared with 2 elements, but has 3 in its FMU; correct one",
        ),
        (
            connector("tick", "output"),
            "third.tick: is of type Clock, which is not supported; use numbers",
        ),
        (
            connector("length", "parameter", "<ssc:Float64/>"),
            "third.length: is declared Float64, but the FMU's variable is Float32; correct one",
        ),
    ],
)
def test_what_fmi_three_has_and_we_do_not_is_refused(lab: Lab, connected: str, sentence: str) -> None:
    text = ssd(system(component("third", "resources/Link3.fmu", connected)))
    with pytest.raises(InputError) as refusal:
        lab.read(text, {"resources/Link3.fmu": lab.fmu("Link3", FMI3).read_bytes()})
    assert str(refusal.value) == sentence


def test_a_start_value_of_an_input_that_is_fed_is_remarked_on(lab: Lab) -> None:
    fed = connection("motor.heat_flow", "link.heat_flow")
    read = lab.read(lab.cell(fed, link=parameters("heat_flow:Real:5")))
    told = "link.heat_flow: its start value 5.0 has no effect once the run has begun, since motor.heat_flow"
    assert [each for each in read.remarks if each.startswith(told)] == list(read.remarks) != []


def test_an_unpacked_description_may_refer_to_fmus_outside_its_folder(lab: Lab) -> None:
    """As those of a repository do, which its user has on disk; one inside an SSP may not."""
    folder = lab.folder / "systems" / "one"
    folder.mkdir(parents=True)
    (lab.folder / "Link.fmu").write_bytes(bytes(lab.entries()["resources/Link.fmu"]))  # type: ignore[arg-type]
    (folder / "SystemStructure.ssd").write_text(ssd(system(component("link", "../../Link.fmu"))), "utf-8")
    read = read_system(folder / "SystemStructure.ssd", lab.folder / "work")
    assert list(read.components) == ["link"]
    with pytest.raises(InputError, match="leads outside the SSP"):
        lab.read(ssd(system(component("link", "../../Link.fmu"))))

"""Everything that does not fit or is not supported is refused in one sentence that says where and why."""

# ruff: noqa: E501 - a sentence stands on one line, as its reader sees it

from __future__ import annotations

from dataclasses import dataclass

import pytest

from warmlink.fmus.errors import InputError

from .ssp_text import (
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
    system,
    write_zip,
)

LINEAR = '<ssc:LinearTransformation factor="2"/>'


@dataclass(frozen=True)
class Case:
    """An SSD and the sentence that refuses it."""

    name: str
    text: str
    sentence: str


def cell(*connections: str, motor: str = "", link: str = "", before: str = "", after: str = "") -> str:
    elements = component("motor", "resources/Motor.fmu", MOTOR_CONNECTORS, motor)
    elements += component("link", "resources/Link.fmu", LINK_CONNECTORS, link)
    return ssd(system(elements, "".join(connections), before=before, after=after))


def alone(
    connectors: str = "", bindings: str = "", attributes: str = "", fmu: str = "resources/Link.fmu"
) -> str:
    return ssd(system(component("link", fmu, connectors, bindings, attributes)))


def mapped(entries: str, *values: str) -> str:
    return parameters(*values).replace(
        "</ssd:ParameterBinding>", mapping(entries) + "</ssd:ParameterBinding>"
    )


def odd_files(lab: Lab) -> dict[str, str | bytes]:
    """Give FMUs that no system can use, under the names by which the cases refer to them."""
    texts = {
        "Exchange": fmi2("Exchange", LINK, "ModelExchange"),
        "Old": '<fmiModelDescription fmiVersion="1.0"/>',
    }
    files: dict[str, str | bytes] = {
        f"resources/{name}.fmu": lab.fmu(name, text).read_bytes() for name, text in texts.items()
    }
    files["resources/Empty.fmu"] = write_zip(lab.folder / "Empty.fmu", {"readme.txt": "nothing"}).read_bytes()
    files["resources/Broken.fmu"] = b"PK no zip"
    return files


CASES = [
    Case(
        "quantity",
        cell(connection("motor.heat_flow", "link.ambient")),
        "motor.heat_flow -> link.ambient: W does not convert to K; connect variables of one quantity",
    ),
    Case(
        "type",
        cell(connection("motor.steps", "link.ambient")),
        "motor.steps -> link.ambient: Integer does not convert to Real; connect variables of one type",
    ),
    Case(
        "difference",
        cell(connection("motor.rise", "motor.ambient")),
        "motor.rise -> motor.ambient: a difference in degC does not convert to a temperature in K; connect two differences or two temperatures",
    ),
    Case(
        "second_driver",
        cell(
            connection("motor.heat_flow", "link.heat_flow"), connection("motor.heat_flow", "link.heat_flow")
        ),
        "motor.heat_flow -> link.heat_flow: link.heat_flow is driven by motor.heat_flow already; one connection may enter an input",
    ),
    Case(
        "two_inputs",
        cell(connection("motor.ambient", "link.ambient")),
        "motor.ambient -> link.ambient: input does not connect to input; connect an output to an input",
    ),
    Case(
        "two_outputs",
        cell(connection("motor.heat_flow", "link.temperature")),
        "motor.heat_flow -> link.temperature: output does not connect to output; connect an output to an input",
    ),
    Case(
        "absent_component",
        cell(connection("motor.heat_flow", "rod.heat_flow")),
        "motor.heat_flow -> rod.heat_flow: there is no component rod; choose motor or link, or add it",
    ),
    Case(
        "absent_connector",
        cell(connection("motor.heat_flow", "link.heat")),
        "motor.heat_flow -> link.heat: link has no connector heat; declare it or correct the name",
    ),
    Case(
        "absent_system_connector",
        cell(connection("motor.heat_flow", "heat")),
        "motor.heat_flow -> heat: the system has no connector heat; declare it or correct the name",
    ),
    Case(
        "into_parameter",
        cell(connection("link.rate", "link.length")),
        "link.rate -> link.length: calculatedParameter does not connect to parameter; give the parameter a start value",
    ),
    Case(
        "from_parameter",
        cell(connection("link.length", "link.ambient")),
        "link.length -> link.ambient: parameter does not connect to input; connect an output to an input",
    ),
    Case(
        "transformed_integer",
        cell(connection("motor.steps", "link.mode", LINEAR)),
        "motor.steps -> link.mode: a linear transformation needs Real variables, these are Integer; remove it",
    ),
    Case(
        "mapping_transformation",
        cell(connection("motor.steps", "link.mode", "<ssc:IntegerMappingTransformation/>")),
        "motor.steps -> link.mode: the element IntegerMappingTransformation is not supported; remove it or write it another way",
    ),
    Case(
        "indices",
        cell(connection("motor.heat_flow", "link.heat_flow", attributes='startIndices="1"')),
        "motor.heat_flow -> link.heat_flow: startIndices is not supported; connect scalars",
    ),
    Case(
        "bad_flag",
        cell(connection("motor.heat_flow", "link.heat_flow", attributes='suppressUnitConversion="maybe"')),
        "motor.heat_flow -> link.heat_flow: suppressUnitConversion is 'maybe', neither true nor false",
    ),
    Case(
        "factor_not_a_number",
        cell(connection("motor.heat_flow", "link.heat_flow", LINEAR.replace("2", "two"))),
        "motor.heat_flow -> link.heat_flow: factor: 'two' is not a number",
    ),
    Case(
        "unknown_connector",
        alone(connector("heat", "input")),
        "link.heat: Link.fmu has no variable heat; did you mean heat_flow?",
    ),
    Case(
        "wrong_kind",
        alone(connector("ambient", "output")),
        "link.ambient: is declared output, but the FMU's variable is input; correct one",
    ),
    Case(
        "inout",
        alone(connector("ambient", "inout")),
        "link.ambient: connectors of kind inout are not supported; use input or output",
    ),
    Case(
        "wrong_type",
        alone(connector("ambient", "input", "<ssc:Integer/>")),
        "link.ambient: is declared Integer, but the FMU's variable is Real; correct one",
    ),
    Case(
        "binary",
        alone(connector("ambient", "input", "<ssc:Binary/>")),
        "link.ambient: is declared Binary, but the FMU's variable is Real; correct one",
    ),
    Case(
        "array",
        alone(connector("ambient", "input", '<ssc:Real/><ssc:Dimension size="3"/>')),
        "link.ambient: array and clocked connectors are not supported; connect scalars",
    ),
    Case(
        "wrong_unit",
        alone(connector("ambient", "input", '<ssc:Real unit="W"/>')),
        "link.ambient: K does not convert to W; declare the connector in a unit of its variable",
    ),
    Case(
        "unknown_unit",
        alone(connector("ambient", "input", '<ssc:Real unit="furlong per fortnite"/>')),
        "link.ambient: 'furlong per fortnite' is not a known unit; define it with a BaseUnit, or write it as in W/(m2.K)",
    ),
    Case(
        "connector_twice",
        alone(connector("ambient", "input") * 2),
        "link.ambient: is declared twice; connectors of one element differ in name",
    ),
    Case(
        "component_twice",
        ssd(system(component("link", "resources/Link.fmu") * 2)),
        "SystemStructure.ssd: holds two elements named 'link', or one without name; rename one",
    ),
    Case(
        "nameless",
        ssd(system(component("", "resources/Link.fmu"))),
        "SystemStructure.ssd: holds two elements named '', or one without name; rename one",
    ),
    Case(
        "absent_fmu",
        alone(fmu="resources/Rod.fmu"),
        "link: the SSP holds no resources/Rod.fmu; add the file or correct the source",
    ),
    Case(
        "outside",
        alone(fmu="../Link.fmu"),
        "link: source '../Link.fmu' leads outside the SSP; put the file into resources",
    ),
    Case(
        "address",
        alone(fmu="https://example.org/Link.fmu"),
        "link: source 'https://example.org/Link.fmu' is not a file inside the SSP; put it into resources",
    ),
    Case(
        "no_source",
        alone().replace('source="resources/Link.fmu"', ""),
        "link: names no source, so that there is nothing to run; give it an FMU",
    ),
    Case(
        "model_exchange_asked",
        alone(attributes='implementation="ModelExchange"'),
        "link: implementation ModelExchange is not supported; use CoSimulation",
    ),
    Case(
        "model_exchange_only",
        alone(fmu="resources/Exchange.fmu"),
        "link: Exchange.fmu: modelDescription.xml: offers ModelExchange, not co-simulation; export the model for co-simulation",
    ),
    Case(
        "modelica",
        alone(attributes='type="text/x-modelica; path=Rod"'),
        "link: components of type text/x-modelica; path=Rod are not supported; export an FMU",
    ),
    Case(
        "fmi1",
        alone(fmu="resources/Old.fmu"),
        "link: Old.fmu: modelDescription.xml: FMI version '1.0' is not supported; give an FMU of FMI 2.0 or 3.0",
    ),
    Case(
        "no_description",
        alone(fmu="resources/Empty.fmu"),
        "link: Empty.fmu: holds no modelDescription.xml; it is not a complete archive of its kind",
    ),
    Case(
        "not_a_zip",
        alone(fmu="resources/Broken.fmu"),
        "link: Broken.fmu: not a readable zip archive (File is not a zip file); make it anew",
    ),
    Case(
        "signal_dictionary",
        cell(after="<ssd:SignalDictionaries/>"),
        "SystemStructure.ssd: the element SignalDictionaries is not supported; remove it or write it another way",
    ),
    Case(
        "signal_dictionary_reference",
        ssd(system('<ssd:SignalDictionaryReference name="bus" dictionary="bus"/>')),
        "bus: SignalDictionaryReference is not supported; connect the components directly",
    ),
    Case(
        "no_component", ssd(system()), "cell1.ssp: the system cell has no component; there is nothing to run"
    ),
    Case(
        "version",
        cell().replace('version="1.0" name="cell"', 'version="3.0" name="cell"'),
        "SystemStructure.ssd: version '3.0' is not supported; use SSP 1.0 or 2.0",
    ),
    Case(
        "other_document",
        "<html/>",
        "SystemStructure.ssd: its root is html, not SystemStructureDescription of SSP 1.0 or 2.0",
    ),
    Case(
        "not_xml",
        "<ssd:System",
        "SystemStructure.ssd: not well-formed XML (Namespace prefix ssd on System is not defined, line 1, column 12); make it anew",
    ),
    Case(
        "doctype",
        '<!DOCTYPE a [<!ENTITY b "c">]>' + cell(),
        "SystemStructure.ssd: declares a document type, which could hold entities; remove the DOCTYPE",
    ),
    Case(
        "itself",
        alone(fmu="SystemStructure.ssd", attributes='type="application/x-ssp-definition"'),
        "SystemStructure.ssd: holds itself as a component; take it out",
    ),
    Case(
        "flat_name_twice",
        ssd(
            system(
                system(component("link", "resources/Link.fmu"), name="arm")
                + component("arm.link", "resources/Link.fmu")
            )
        ),
        "arm.link: is the name of two components once systems are flat; rename one",
    ),
    Case(
        "unknown_element",
        cell(after="<ssd:Magic/>"),
        "SystemStructure.ssd: the element Magic is not supported; remove it or write it another way",
    ),
    Case(
        "value_type",
        cell(link=parameters("length:String:long")),
        "link.length: is given a value of type String, but is of type Real; give a value of that type",
    ),
    Case(
        "value_not_finite",
        cell(link=parameters("length:Real:NaN")),
        "link: ParameterSet: length: 'NaN' is not a finite number",
    ),
    Case(
        "value_below",
        cell(link=parameters("length:Real:-20:mm")),
        "link.length: -0.02 m is below its minimum; give at least 0 m",
    ),
    Case(
        "value_above",
        cell(link=parameters("length:Real:11")),
        "link.length: 11 m is above its maximum; give at most 10 m",
    ),
    Case(
        "value_too_long",
        cell(link=parameters("cells:Integer:4294967298")),
        "link.cells: 4294967298 does not fit into 32 bits; give -2147483648 to 2147483647",
    ),
    Case(
        "value_unit",
        cell(link=parameters("length:Real:11:K")),
        "link.length: K does not convert to m; give the value in a unit of its variable",
    ),
    Case(
        "value_of_output",
        cell(link=parameters("elongation:Real:1")),
        "link.elongation: takes no start value, its causality being output and its variability continuous; set a parameter or an input",
    ),
    Case(
        "value_item",
        cell(link=parameters("metal:Enumeration:wood")),
        "link.metal: 'wood' is not an item of its enumeration; choose steel or brass",
    ),
    Case(
        "value_binary",
        cell(link=parameters("label:Binary:00")),
        "link: ParameterSet: label: values of type Binary are not supported; use Real, Integer, Boolean or String",
    ),
    Case(
        "value_twice",
        cell(link=parameters("length:Real:1", "length:Real:2")),
        "link: ParameterSet: gives the parameter length twice; keep one",
    ),
    Case(
        "value_on_system_output",
        ssd(
            system(
                component("link", "resources/Link.fmu", LINK_CONNECTORS),
                connection("link.temperature", "tip"),
                before="<ssd:Connectors>"
                + connector("tip", "output")
                + "</ssd:Connectors><ssd:ParameterBindings>"
                + parameters("tip:Real:1")
                + "</ssd:ParameterBindings>",
            )
        ),
        "tip: takes no start value, being output; set an input or parameter",
    ),
    Case(
        "mapping_target",
        cell(link=mapped(entry("L", "lenght"), "L:Real:1")),
        "link: ParameterSet: its mapping names lenght, which does not exist; correct it",
    ),
    Case(
        "mapping_integer",
        cell(link=mapped(entry("n", "cells", LINEAR), "n:Integer:10")),
        "link.cells: a linear transformation needs a Real, this is Integer; remove it",
    ),
    Case(
        "binding_type",
        cell(link=binding(attributes='type="text/csv" source="a.csv"')),
        "link: parameters of type text/csv are not supported; use application/x-ssp-parameter-set",
    ),
    Case(
        "binding_empty",
        cell(link=binding()),
        "link: a parameter binding has neither a source nor a ParameterSet inside",
    ),
    Case(
        "binding_absent",
        cell(link=binding(attributes='source="resources/rod.ssv"')),
        "link: the SSP holds no resources/rod.ssv; add the file or correct the source",
    ),
    Case(
        "binding_base",
        cell(link=binding(attributes='source="rod.ssv" sourceBase="component"')),
        "link: sourceBase component is not supported; move it to the SSP",
    ),
    Case(
        "binding_other",
        cell(link=binding(attributes='source="SystemStructure.ssd"')),
        "link: SystemStructure.ssd: its root is SystemStructureDescription, not ParameterSet of SSP 1.0 or 2.0",
    ),
    Case(
        "stop_time",
        cell().replace(
            "</ssd:SystemStructureDescription>",
            '<ssd:DefaultExperiment stopTime="soon"/></ssd:SystemStructureDescription>',
        ),
        "SystemStructure.ssd: stopTime: 'soon' is not a number",
    ),
    Case(
        "stop_before_start",
        ssd(system(), after='<ssd:DefaultExperiment startTime="2" stopTime="1"/>'),
        "SystemStructure.ssd: stopTime 1 s is not after startTime 2 s; give a later one",
    ),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_refused_in_one_sentence(lab: Lab, case: Case) -> None:
    with pytest.raises(InputError) as refusal:
        lab.read(case.text, odd_files(lab))
    assert str(refusal.value) == case.sentence
    assert "\n" not in case.sentence

"""Components, files, documents and values that do not fit or are not supported are refused in one sentence that says where and why."""

# ruff: noqa: E501 - a sentence stands on one line, as its reader sees it

from __future__ import annotations

import pytest

from warmlink.fmus.errors import InputError

from .ssp_text import (
    LINEAR,
    LINK,
    LINK_CONNECTORS,
    Case,
    Lab,
    alone,
    binding,
    cell,
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


def mapped(entries: str, *values: str) -> str:
    return parameters(*values).replace(
        "</ssd:ParameterBinding>", mapping(entries) + "</ssd:ParameterBinding>"
    )


def odd_files(lab: Lab) -> dict[str, str | bytes]:
    """Give FMUs that no system can use, under the names by which the cases refer to them."""
    texts = {
        "Exchange": fmi2("Exchange", LINK, "ModelExchange"),
        "None": '<fmiModelDescription fmiVersion="3.0"/>',
        "New": '<fmiModelDescription fmiVersion="4.0"/>',
    }
    files: dict[str, str | bytes] = {
        f"resources/{name}.fmu": lab.fmu(name, text).read_bytes() for name, text in texts.items()
    }
    files["resources/Empty.fmu"] = write_zip(lab.folder / "Empty.fmu", {"readme.txt": "nothing"}).read_bytes()
    files["resources/Broken.fmu"] = b"PK no zip"
    return files


CASES = [
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
        "link: Link.fmu: offers CoSimulation, not ModelExchange; export the model for it, or leave the choice to the master (any)",
    ),
    Case(
        "co_simulation_asked",
        alone(fmu="resources/Exchange.fmu", attributes='implementation="CoSimulation"'),
        "link: Exchange.fmu: offers ModelExchange, not CoSimulation; export the model for it, or leave the choice to the master (any)",
    ),
    Case(
        "other_interface_asked",
        alone(attributes='implementation="ScheduledExecution"'),
        "link: implementation ScheduledExecution is not supported; use any, CoSimulation or ModelExchange",
    ),
    Case(
        "no_interface",
        alone(fmu="resources/None.fmu"),
        "link: None.fmu: modelDescription.xml: offers no interface; export the model for co-simulation",
    ),
    Case(
        "modelica",
        alone(attributes='type="text/x-modelica; path=Rod"'),
        "link: components of type text/x-modelica; path=Rod are not supported; export an FMU",
    ),
    Case(
        "fmi4",
        alone(fmu="resources/New.fmu"),
        "link: New.fmu: modelDescription.xml: FMI version '4.0' is not supported; give an FMU of FMI 1.0, 2.0 or 3.0",
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
        cell(link=parameters("label:Clock:00")),
        "link: ParameterSet: label: values of type Clock are not supported; use Real, Integer, Boolean or String",
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

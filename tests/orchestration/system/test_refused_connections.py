"""Connections and connectors that do not fit or are not supported are refused in one sentence that says where and why."""

# ruff: noqa: E501 - a sentence stands on one line, as its reader sees it

from __future__ import annotations

import pytest

from warmlink.fmus.errors import InputError

from .ssp_text import (
    LINEAR,
    Case,
    Lab,
    alone,
    cell,
    connection,
    connector,
)

TWICE = (
    '<ssc:IntegerMappingTransformation><ssc:MapEntry source="1" target="2"/><ssc:MapEntry source="1" target="3"/>'
    "</ssc:IntegerMappingTransformation>"
)
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
        "table_of_another_type",
        cell(connection("motor.steps", "link.mode", "<ssc:BooleanMappingTransformation/>")),
        "motor.steps -> link.mode: a table of Boolean values does not map Integer to Integer; remove it or choose another",
    ),
    Case(
        "table_with_two_targets",
        cell(connection("motor.steps", "link.mode", TWICE)),
        "motor.steps -> link.mode: maps the value 1 twice; keep one entry",
    ),
    Case(
        "two_transformations",
        cell(connection("motor.steps", "link.mode", "<ssc:IntegerMappingTransformation/>" + LINEAR)),
        "motor.steps -> link.mode: has more than one transformation; keep one",
    ),
    Case(
        "indices",
        cell(connection("motor.heat_flow", "link.heat_flow", attributes='startIndices="1"')),
        "motor.heat_flow[1] -> link.heat_flow: motor has no connector heat_flow[1]; declare it or correct the name",
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
        cell(connection("motor.heat_flow", "link.heat")).replace(
            'name="heat_flow" kind="input"', 'name="heat" kind="input"'
        ),
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
        "link.ambient: is declared with 3 elements, but has 1 in its FMU; correct one",
    ),
    *(
        Case(
            f"array_of_{size}",
            alone(connector("ambient", "input", f'<ssc:Real/><ssc:Dimension size="{size}"/>' + more)),
            f"link.ambient: has {told}",
        )
        for size, more, told in (
            ("0", "", "a dimension of 0 elements; give at least one"),
            ("-1", "", "a dimension of -1 elements; give at least one"),
            ("99999", '<ssc:Dimension size="99999"/>', "9999800001 elements; give at most 100000"),
        )
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
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_refused_in_one_sentence(lab: Lab, case: Case) -> None:
    with pytest.raises(InputError) as refusal:
        lab.read(case.text)
    assert str(refusal.value) == case.sentence
    assert "\n" not in case.sentence

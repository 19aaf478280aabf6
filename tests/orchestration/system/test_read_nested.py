"""Reading SSPs with systems inside systems: they become flat, and what lies between adds up."""

from __future__ import annotations

import pytest

from warmlink.orchestration.system.model import Connection

from .ssp_text import (
    LINEAR,
    LINK_CONNECTORS,
    MOTOR_CONNECTORS,
    Lab,
    component,
    connection,
    connector,
    parameters,
    ssd,
    system,
    write_zip,
)


def nested(before: str = "", unit: str = "K") -> str:
    """Give an axis (motor and link) inside an arm, its temperature and heat flow led through."""
    real = f'<ssc:Real unit="{unit}"/>'
    led = (
        connector("surroundings", "input", real)
        + connector("tip", "output", real)
        + connector("size", "parameter")
    )
    inside = component("motor", "resources/Motor.fmu", MOTOR_CONNECTORS)
    inside += component("link", "resources/Link.fmu", LINK_CONNECTORS)
    axis = system(
        inside,
        connection("motor.heat_flow", "link.heat_flow")
        + connection("surroundings", "motor.ambient")
        + connection("surroundings", "link.ambient")
        + connection("link.temperature", "tip")
        + connection("size", "link.length"),
        "axis",
        before=f"<ssd:Connectors>{led}</ssd:Connectors>{before}",
    )
    room = component("room", "resources/Link.fmu", LINK_CONNECTORS)
    return axis + room


def test_nested_systems_become_flat_with_dotted_names(lab: Lab) -> None:
    outer = connection("room.temperature", "axis.surroundings") + connection("axis.tip", "room.ambient")
    read = lab.read(ssd(system(nested(), outer)))
    assert list(read.components) == ["axis.motor", "axis.link", "room"]
    assert set(read.connections) == {
        Connection("axis.motor", "heat_flow", "axis.link", "heat_flow"),
        Connection("room", "temperature", "axis.motor", "ambient"),
        Connection("room", "temperature", "axis.link", "ambient"),
        Connection("axis.link", "temperature", "room", "ambient"),
    }


def test_units_and_transformations_add_up_on_the_way_through_systems(lab: Lab) -> None:
    outer = connection("room.temperature", "axis.surroundings", LINEAR)
    read = lab.read(ssd(system(nested(unit="degC"), outer)))
    found = {link.target: link.factor * 300.0 + link.offset for link in read.connections}
    # K to degC, transformed there, degC to K.
    assert found["axis.link.ambient"] == pytest.approx(2 * 26.85 + 1 + 273.15, abs=1e-12)


def test_what_drives_nothing_from_outside_leaves_inner_inputs_unconnected(lab: Lab) -> None:
    read = lab.read(ssd(system(nested())))
    assert {link.target for link in read.connections} == {"axis.link.heat_flow"}


def test_a_systems_connector_hands_its_start_value_on(lab: Lab) -> None:
    given = parameters("surroundings:Real:30:degC", "size:Real:250:mm", "motor.torque_constant:Real:2")
    read = lab.read(ssd(system(nested(f"<ssd:ParameterBindings>{given}</ssd:ParameterBindings>"))))
    assert read.components["axis.motor"].values == {
        "ambient": pytest.approx(303.15, rel=1e-15),
        "torque_constant": 2.0,
    }
    assert read.components["axis.link"].values == {
        "ambient": pytest.approx(303.15, rel=1e-15),
        "length": pytest.approx(0.25, rel=1e-15),
    }


def test_an_outer_binding_reaches_into_nested_systems_and_wins(lab: Lab) -> None:
    inner = f"<ssd:ParameterBindings>{parameters('size:Real:1')}</ssd:ParameterBindings>"
    outer = f"<ssd:ParameterBindings>{parameters('axis.link.length:Real:2')}</ssd:ParameterBindings>"
    read = lab.read(ssd(system(nested(inner), before=outer)))
    assert read.components["axis.link"].values == {"length": 2.0}


def test_a_component_may_be_another_ssp_or_ssd(lab: Lab) -> None:
    inner = write_zip(
        lab.folder / "axis.ssp",
        {"SystemStructure.ssd": lab.cell(connection("motor.heat_flow", "link.heat_flow")), **lab.entries()},
    )
    kinds = ('type="application/x-ssp-package"', 'type="application/x-ssp-definition"')
    elements = component("packed", "resources/axis.ssp", "", parameters("link.length:Real:1"), kinds[0])
    elements += component("beside", "axis.ssd", "", "", kinds[1])
    more: dict[str, str | bytes] = {
        "resources/axis.ssp": inner.read_bytes(),
        "axis.ssd": lab.cell(connection("motor.heat_flow", "link.heat_flow")),
    }
    read = lab.read(ssd(system(elements)), more)
    assert list(read.components) == ["packed.motor", "packed.link", "beside.motor", "beside.link"]
    assert read.components["packed.link"].values == {"length": 1.0}
    assert {link.source for link in read.connections} == {"packed.motor.heat_flow", "beside.motor.heat_flow"}


def test_a_difference_reaches_its_variable_through_systems_without_the_zero_of_a_scale(lab: Lab) -> None:
    rise = connector("rise", "input", '<ssc:Real unit="degC"/>')
    inner = system(
        component("link", "resources/Link.fmu", LINK_CONNECTORS),
        connection("rise", "link.difference"),
        "arm",
        before=f"<ssd:Connectors>{rise}</ssd:Connectors>",
    )
    motor = component("motor", "resources/Motor.fmu", MOTOR_CONNECTORS)
    given = f"<ssd:ParameterBindings>{parameters('arm.rise:Real:5:degC')}</ssd:ParameterBindings>"
    read = lab.read(ssd(system(motor + inner, connection("motor.rise", "arm.rise"), before=given)))
    assert read.components["arm.link"].values == {"difference": 5.0}
    assert read.connections == (Connection("motor", "rise", "arm.link", "difference"),)

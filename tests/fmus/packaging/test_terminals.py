"""terminalsAndIcons.xml against the schema of FMI 3.0 and the wires of the shipped cell."""

from __future__ import annotations

from pathlib import Path

import pytest

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.component import Component, Input, Output, Terminal
from warmlink.fmus.packaging.beside import terminals_files
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.machine.shipped import WARMUP_CELL

COMPONENTS = {entry.component.name: entry.component for entry in catalogue()}
LAW = controller("lag")


@pytest.mark.parametrize("component", [*COMPONENTS.values(), WARMUP_CELL.joined(LAW)], ids=lambda c: c.name)
@pytest.mark.parametrize("arrays", [False, True])
def test_terminals_are_valid_and_name_variables(component: Component, arrays: bool) -> None:
    import fmpy
    from lxml import etree

    files = terminals_files(component, arrays)
    assert bool(files) == bool(component.terminals)
    known = {s.variable.name if arrays else s.name for s in component.scalars()}
    schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    for content in files.values():
        etree.XMLSchema(etree.parse(str(schema))).assertValid(etree.fromstring(content))
        for terminal in etree.fromstring(content).iter("Terminal"):
            members = [(each.get("variableName"), each.get("memberName")) for each in terminal]
            assert {variable for variable, _ in members} <= known
            assert len({member for _, member in members}) == len(members)


def terminal(instance: str, name: str) -> Terminal:
    component = COMPONENTS[WARMUP_CELL.parts_with(LAW.name)[instance]]
    return next(each for each in component.terminals if each.name == name)


@pytest.mark.parametrize(
    ("one", "other", "terminals"),
    [
        ("motor", "link", [("joint", "base")]),
        ("duty", "motor", [("duty", "duty")]),
        ("duty", "compensator", [("duty", "duty")]),
        ("sensors", "compensator", [("readings", "readings")]),
        ("camera", "compensator", [("camera", "camera"), ("compensation", "compensation")]),
    ],
)
def test_connected_terminals_are_the_wires_of_the_cell(
    one: str, other: str, terminals: list[tuple[str, str]]
) -> None:
    pairs = set()
    for ends in terminals:
        this, that = terminal(one, ends[0]), terminal(other, ends[1])
        assert this.kind == that.kind
        a, b = dict(this.members), dict(that.members)
        pairs |= {frozenset((f"{one}.{a[m]}", f"{other}.{b[m]}")) for m in a.keys() & b.keys()}
    wires = [wire for wire in WARMUP_CELL.wires if {end.split(".")[0] for end in wire} == {one, other}]
    assert pairs == {frozenset(wire) for wire in wires}


def test_a_member_is_given_by_one_side_and_taken_by_the_other() -> None:
    kinds = {s.name: type(s.variable) for s in COMPONENTS["MotorHeatSource"].scalars()}
    assert [kinds[scalar] for _, scalar in terminal("motor", "joint").members] == [Output, Input]
    kinds = {s.name: type(s.variable) for s in COMPONENTS["ThermalLink"].scalars()}
    assert [kinds[scalar] for _, scalar in terminal("link", "base").members] == [Input, Output]

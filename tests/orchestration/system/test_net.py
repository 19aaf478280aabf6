"""Who drives whom in a system of systems: connections directed, chained, and refused."""

from __future__ import annotations

from typing import Any, cast

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.model import Connector
from warmlink.orchestration.system.ssp.net import Edge, Element, Net, Node

Path = tuple[str, ...]
FMU = cast(Any, object())
"""What stands for a description: that an element is a component."""


def ends(**kinds: str) -> dict[str, Connector]:
    return {name: Connector(cast(Any, kind)) for name, kind in kinds.items()}


def edge(source: str, target: str) -> Edge:
    """`inner.a.y`: connector y of the component a in the system inner."""

    def node(text: str) -> Node:
        *path, connector = text.split(".")
        return Node(tuple(path), connector)

    return Edge(node(source), node(target))


def net(*connections: tuple[Path, Edge], **more: dict[str, Connector]) -> Net:
    """A system with the components a and b, and in its system `inner` the component c."""
    component = ends(u="input", v="input", y="output", p="parameter")
    made = Net(
        {
            (): Element(more.get("outer", {})),
            ("a",): Element(component, info=FMU),
            ("b",): Element(component, info=FMU),
            ("inner",): Element(ends(to="input", out="output")),
            ("inner", "c"): Element(component, info=FMU),
        }
    )
    for within, each in connections:
        made.elements[within].connections.append(each)
    return made


def test_a_connection_runs_as_data_flows_whichever_way_it_is_declared() -> None:
    declared = net(((), edge("a.y", "b.u")), ((), edge("a.u", "b.y")))
    assert [str(each) for each in declared.into.values()] == ["a.y -> b.u", "b.y -> a.u"]


def test_a_way_goes_through_the_connectors_of_systems_in_between() -> None:
    through = net(
        ((), edge("a.y", "inner.to")),
        (("inner",), edge("inner.to", "inner.c.u")),
        (("inner",), edge("inner.c.y", "inner.out")),
        ((), edge("inner.out", "b.u")),
    )
    assert sorted([str(each) for each in way] for way in through.ways) == [
        ["a.y -> inner.to", "inner.to -> inner.c.u"],
        ["inner.c.y -> inner.out", "inner.out -> b.u"],
    ]
    assert [len(way) for way in through.onward[Node(("inner",), "to")]] == [1]


@pytest.mark.parametrize(
    ("connections", "sentence"),
    [
        ([((), edge("a.y", "b.u")), ((), edge("inner.out", "b.u"))], "b.u is driven by a.y already"),
        ([((), edge("a.y", "b.y"))], "output does not connect to output; connect an output to an input"),
        (
            [((), edge("a.y", "b.p"))],
            "output does not connect to parameter; give the parameter a start value",
        ),
        ([((), edge("a.p", "b.u"))], "parameter does not connect to input; connect an output to an input"),
        ([((), edge("a.y", "d.u"))], "there is no component d; choose a, b or inner.c, or add it"),
        ([((), edge("a.y", "b.w"))], "b has no connector w; declare it or correct the name"),
    ],
)
def test_what_cannot_be_connected_is_refused(connections: list[tuple[Path, Edge]], sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        assert net(*connections).into
    assert sentence in str(refused.value)


def test_connectors_of_systems_that_drive_each_other_are_refused() -> None:
    round_about = net(
        ((), edge("inner.out", "inner.to")),
        (("inner",), edge("inner.to", "inner.out")),
        (("inner",), edge("inner.to", "inner.c.u")),
    )
    with pytest.raises(InputError, match="the connectors of systems drive each other in a circle"):
        assert round_about.ways


def test_a_name_that_two_components_have_once_systems_are_flat_is_refused() -> None:
    twice = net()
    twice.elements["inner.c",] = Element(info=FMU)
    with pytest.raises(InputError, match=r"inner\.c: is the name of two components"):
        assert twice.components

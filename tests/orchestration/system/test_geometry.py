"""Where an editor draws the parts of a system."""

from __future__ import annotations

from itertools import combinations

from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.machine.shipped import WARMUP_CELL, machine_named
from warmlink.orchestration.system.drawing import Box, boxes, places


def apart(one: Box, other: Box) -> bool:
    return one[2] < other[0] or other[2] < one[0] or one[3] < other[1] or other[3] < one[1]


def drawn(wires: tuple[tuple[str, str], ...], parts: list[str]) -> dict[str, Box]:
    links = [(a.rpartition(".")[0], b.rpartition(".")[0]) for a, b in wires]
    return boxes(dict.fromkeys(parts, ["input"] * 5), links)


def test_the_cell_is_drawn_along_its_signals() -> None:
    parts = list(WARMUP_CELL.parts_with(controller("lag").name))
    found = drawn(WARMUP_CELL.wires, parts)
    left = {name: box[0] for name, box in found.items()}
    order = ("duty", "motor", "link", "sensors", "compensator")
    assert sorted(order, key=left.__getitem__) == list(order)
    assert left["camera"] == left["sensors"]
    rod = machine_named("BenchRod")
    for each in (found, drawn(rod.wires, list(rod.parts))):
        assert all(apart(a, b) for a, b in combinations(each.values(), 2))


def test_connectors_stand_on_the_edges_in_their_order() -> None:
    found = places(["input", "parameter", "output", "input"])
    assert found == [(0.0, 1 - 1 / 3), None, (1.0, 0.5), (0.0, 1 - 2 / 3)]

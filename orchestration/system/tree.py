"""A system as it is written: a tree, whose inner systems show connectors to what is around them.

The reverse of reading: a connection from one inner system into another becomes a chain through connectors
that the systems on the way show. An editor draws the parts by data flow, as a person would.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field, replace
from itertools import takewhile
from typing import Literal

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.views import flag_of
from warmlink.fmus.records import dataclass
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import CONNECTOR_KINDS, Component, Connection, Connector, System
from warmlink.orchestration.system.ssp.net import Edge, Node, edge_of

WIDTH, GAP, PITCH = 40.0, 40.0, 4.0
"""Width of a part, space between parts, and height for each connector, in the units of the drawing (mm)."""

Box = tuple[float, float, float, float]
"""x1, y1 of the lower left corner and x2, y2 of the upper right one; y grows upward."""

End = tuple[str, str]
"""Name of a component and of one of its variables."""


@dataclass(frozen=True)
class Ports:
    """What a system exchanges with a larger one that holds it.

    An input of the system takes the place of each output of the `drivers`, which are left out; outputs of the
    system pass on what is `shown`, as `("link", "elongation")`.
    """

    drivers: tuple[str, ...]
    shown: tuple[End, ...]


@dataclass(frozen=True)
class SystemConnector:
    """A connector of a system: it carries the values of `source`, hence its type and unit."""

    name: str
    kind: Literal["input", "output"]
    source: End


@dataclass
class Tree:
    """A system with its components by the names that they bear in it, and the systems in it.

    The nodes of its edges are of one of these, or of the system itself, whose path is empty.
    """

    components: dict[str, Component] = field(default_factory=dict)
    systems: dict[str, Tree] = field(default_factory=dict)
    connectors: list[SystemConnector] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)

    def at(self, path: list[str]) -> Tree:
        """Give the system at a path of names."""
        return self.systems[path[0]].at(path[1:]) if path else self

    def shows(self, kind: Literal["input", "output"], source: End, name: str) -> str:
        """Give the connector by which the system passes a source on, made where there is none yet."""
        for known in self.connectors:
            if (known.kind, known.source) == (kind, source):
                return known.name
        taken = {known.name for known in self.connectors}
        while name in taken:
            name += "_"
        self.connectors.append(SystemConnector(name, kind, source))
        return name

    def lay(self, source: Node, target: Node) -> None:
        """Connect two connectors, unless they are."""
        if Edge(source, target) not in self.edges:
            self.edges.append(Edge(source, target))


def tree_of(system: System, nested: bool = False) -> Tree:
    """Give the tree of a system with its connections.

    In a `nested` one each name before a dot is that of a system, and InputError if that of a component too.
    """
    top = Tree()
    for name, held in system.components.items():
        *way, last = _path(name, nested)
        place = top
        for step in way:
            if step in place.components:
                raise InputError(f"{name}: {step} is a component and cannot be a system; rename one")
            place = place.systems.setdefault(step, Tree())
        if last in place.systems:
            raise InputError(f"{name}: is a component and a system; rename one")
        place.components[last] = held
    for link in system.connections:
        _connect(top, link, _path(link.source_component, nested), _path(link.target_component, nested))
    return top


def _path(name: str, nested: bool) -> list[str]:
    return name.split(".") if nested else [name]


def _connect(top: Tree, link: Connection, start: list[str], end: list[str]) -> None:
    """Lay a connection through the tree: out of the source's systems, across, into the target's."""
    steps = zip(start[:-1], end[:-1], strict=False)
    shared = len(list(takewhile(lambda pair: pair[0] == pair[1], steps)))
    source, giving = link.ends[0], Node((start[-1],), link.source_variable)
    for depth in range(len(start) - 1, shared, -1):
        place = top.at(start[:depth])
        name = place.shows("output", source, "_".join((*start[depth:], link.source_variable)))
        place.lay(giving, Node((), name))
        giving = Node((start[depth - 1],), name)
    for depth in range(shared, len(end) - 1):
        name = "_".join((*end[depth + 1 :], link.target_variable))
        name = top.at(end[: depth + 1]).shows("input", source, name)
        top.at(end[:depth]).lay(giving, Node((end[depth],), name))
        giving = Node((), name)
    last = replace(edge_of(link), source=giving, target=Node((end[-1],), link.target_variable))
    top.at(end[:-1]).edges.append(last)


def opened(system: System, ports: Ports) -> tuple[System, Tree]:
    """Give a system without its drivers, and its tree with the connectors that take their place."""
    kept = {name: held for name, held in system.components.items() if name not in ports.drivers}
    links = tuple(c for c in system.connections if c.source_component in kept)
    cut = [c for c in system.connections if c.source_component not in kept]
    inner = replace(system, components=kept, connections=links)
    tree = tree_of(inner)
    given = _names(link.ends[0] for link in cut)
    for link in cut:
        name = given[link.ends[0]]
        if name not in {known.name for known in tree.connectors}:
            tree.connectors.append(SystemConnector(name, "input", link.ends[1]))
        tree.edges.append(replace(edge_of(link), source=Node((), name)))
    flags = [(name, flag_of(variable)) for name, variable in ports.shown]
    there = [(name, flag) for name, flag in flags if flag in read_description(kept[name].fmu).variables]
    for end, name in _names((*ports.shown, *there)).items():
        tree.connectors.append(SystemConnector(name, "output", end))
        tree.lay(Node((end[0],), end[1]), Node((), name))
    return inner, tree


def _names(ends: Iterable[End]) -> dict[End, str]:
    """Name of the connector for each end: its variable's, with the component's where two would be equal."""
    found = list(dict.fromkeys(ends))
    variables = [variable for _, variable in found]
    return {
        (component, variable): variable if variables.count(variable) == 1 else f"{component}_{variable}"
        for component, variable in found
    }


def with_connectors(system: System) -> System:
    """Give the system with connectors everywhere: those who read the file connect nothing else."""
    parts = {
        name: held if held.connectors else replace(held, connectors=_connectors(held, system))
        for name, held in system.components.items()
    }
    for link in system.connections:
        for name, connector in link.ends:
            if name in parts and connector not in {c.name for c in parts[name].connectors}:
                raise InputError(
                    f"{link.source} -> {link.target}: {name} has no connector {connector}; declare it"
                )
    return replace(system, components=parts)


def _connectors(held: Component, system: System) -> tuple[Connector, ...]:
    """Connect outputs, given parameters and what is fed: some tools feed 0 to every other input listed."""
    used = {link.target_variable for link in system.connections if link.target_component == held.name}
    return tuple(
        Connector(v.name, kind, v.kind, v.unit)
        for v in read_description(held.fmu).variables.values()
        for kind in CONNECTOR_KINDS
        if kind == v.causality
        and v.kind is not None
        and not v.dimensions
        and (kind == "output" or v.name in (used if kind == "input" else held.values))
    )


def boxes(heights: Mapping[str, int], links: Iterable[tuple[str, str]]) -> dict[str, Box]:
    """Give each part its place.

    A part stands one column right of the last part before it, in the order given, that feeds it; what comes
    back from later parts moves nothing. The heights are how many connectors a part's longer side has; the
    links name the parts that are connected, from and to, empty for the system around them.
    """
    order = list(heights)
    column: dict[str, int] = {}
    feeding = set(links)
    for place, name in enumerate(order):
        before = [column[giver] for giver in order[:place] if (giver, name) in feeding]
        column[name] = max(before, default=-1) + 1
    top = Counter[int]()
    found = {}
    for name, count in heights.items():
        x, height = column[name] * (WIDTH + GAP), int(PITCH * (count + 1))
        y = 0.0 - top[column[name]]
        top[column[name]] += height + int(GAP / 2)
        found[name] = (x, y - height, x + WIDTH, y)
    return found


def longer_side(kinds: Iterable[str]) -> int:
    """Give how many connectors the longer side of a part has."""
    count = Counter(kinds)
    return max(count["input"], count["output"])


def places(kinds: Sequence[str]) -> list[tuple[float, float] | None]:
    """Give places on a part's edges, from 0 to 1: inputs left, outputs right, others nowhere."""
    side = {"input": 0.0, "output": 1.0}
    count, met = Counter(kinds), Counter[str]()
    found: list[tuple[float, float] | None] = []
    for kind in kinds:
        met[kind] += 1
        x = side.get(kind)
        found.append(None if x is None else (x, 1 - met[kind] / (count[kind] + 1)))
    return found

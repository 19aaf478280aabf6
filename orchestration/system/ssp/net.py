"""A system as its description declares it: components and systems in systems, and who drives whom."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import takewhile
from pathlib import Path as File

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.system.described import described
from warmlink.orchestration.system.model import (
    Connection,
    Connector,
    FmuPart,
    Implementation,
    ModelInfo,
    System,
    Value,
)
from warmlink.orchestration.system.units import Conversion

Path = tuple[str, ...]
"""Names on the way to a component or a system; none for the outermost system."""

# As seen from the system around an element; of a system's own connectors its inside sees the reverse.
_GIVING = ("output", "calculatedParameter", "local", "constant")

_MOST_ELEMENTS = 100_000


@dataclass(frozen=True)
class Node:
    """A connector of a component or of a system."""

    path: Path
    connector: str

    def __str__(self) -> str:
        return ".".join((*self.path, self.connector))


@dataclass(frozen=True)
class ValueMap:
    """Values, of a type of SSP, that become others; those that are no source in the table stay as they are.

    An Enumeration's are the names of its items.
    """

    kind: str
    entries: tuple[tuple[Value, Value], ...]

    def applied(self, value: Value) -> Value:
        """Give what becomes of a value."""
        return dict(self.entries).get(value, value)


@dataclass(frozen=True)
class Edge:
    """A connection between connectors, or an entry of a parameter mapping between names."""

    source: Node
    target: Node
    transformation: Conversion | None = None
    suppress_unit_conversion: bool = False
    values: ValueMap | None = None

    @property
    def ends(self) -> tuple[Node, Node]:
        """Source and target."""
        return self.source, self.target

    def __str__(self) -> str:
        return f"{self.source} -> {self.target}"


def edge_of(link: Connection) -> Edge:
    """Give a connection between components, in the units of their own variables."""
    source, target = (Node((component,), variable) for component, variable in link.ends)
    change = Conversion(link.factor, link.offset)
    kind = "Boolean" if any(isinstance(each, bool) for each, _ in link.values) else "Integer"
    values = ValueMap(kind, link.values) if link.values else None
    return Edge(source, target, None if change.identity else change, not change.identity, values)


@dataclass(frozen=True)
class Element:
    """A component with its FMU, or a system with the connections inside it; connectors by name.

    Of the start values, those count that say how large arrays are.
    """

    connectors: dict[str, Connector] = field(default_factory=dict)
    fmu: File | None = None
    info: ModelInfo | None = None
    connections: list[Edge] = field(default_factory=list)
    implementation: Implementation = "any"
    values: Mapping[str, Value] = field(default_factory=dict)


@dataclass
class Net:
    """Components and systems by path, a system before what is inside it."""

    elements: dict[Path, Element] = field(default_factory=dict)

    def add(self, path: Path, element: Element) -> None:
        """Add a system, or a component, whose FMU's description is read."""
        if len(self.elements) > _MOST_ELEMENTS:
            raise InputError(
                f"{path[0]}: the system has more than {_MOST_ELEMENTS} elements, which none needs"
            )
        if element.fmu is not None:
            try:
                held = dict(element.values)
                part = FmuPart("", element.fmu, values=held, implementation=element.implementation)
                element = replace(element, info=described(part))
            except InputError as fault:
                raise InputError(f"{'.'.join(path)}: {fault}") from fault
        self.elements[path] = element

    def info(self, node: Node) -> ModelInfo | None:
        """Give the description of the FMU that a connector belongs to; None for one of a system."""
        return self.elements[node.path].info

    def declared(self, node: Node) -> Connector | None:
        """Give a connector's declaration, or None if there is none."""
        return self.elements[node.path].connectors.get(node.connector)

    @cached_property
    def components(self) -> dict[Path, Element]:
        """The components by their paths; InputError where two have the same dotted name."""
        found = {path: element for path, element in self.elements.items() if element.info is not None}
        names: set[str] = set()
        for name in map(".".join, found):
            if name in names:
                raise InputError(f"{name}: is the name of two components once systems are flat; rename one")
            names.add(name)
        return found

    @cached_property
    def inside(self) -> dict[Path, list[Path]]:
        """What each system holds, without what that holds."""
        found: dict[Path, list[Path]] = {path: [] for path in self.elements}
        for path in self.elements:
            if path:
                found[path[:-1]].append(path)
        return found

    @cached_property
    def connected(self) -> frozenset[Node]:
        """Ends of all connections."""
        return frozenset(
            node for each in self.elements.values() for edge in each.connections for node in edge.ends
        )

    @cached_property
    def into(self) -> dict[Node, Edge]:
        """The one edge into each connector that is driven.

        InputError where a connection ends nowhere, joins two ends of one direction, or is the second into
        its target.
        """
        into: dict[Node, Edge] = {}
        for path, element in self.elements.items():
            for declared in element.connections:
                edge = self._directed(declared, path)
                first = into.setdefault(edge.target, edge)
                if first is not edge:
                    raise InputError(
                        f"{edge}: {edge.target} is driven by {first.source} already; "
                        "one connection may enter an input"
                    )
        return into

    @cached_property
    def ways(self) -> list[list[Edge]]:
        """For each driven connector of a component the edges up to it, from whatever drives it."""
        ways = []
        for edge in self.into.values():
            if self.info(edge.target) is not None:
                way = [edge]
                while before := self.into.get(way[0].source):
                    if before in way:
                        raise InputError(f"{before}: the connectors of systems drive each other in a circle")
                    way.insert(0, before)
                ways.append(way)
        return ways

    @cached_property
    def onward(self) -> dict[Node, list[list[Edge]]]:
        """For each connector that drives others the ways from it to components."""
        found: dict[Node, list[list[Edge]]] = {}
        for way in self.ways:
            for i, edge in enumerate(way):
                found.setdefault(edge.source, []).append(way[i:])
        return found

    def _directed(self, declared: Edge, within: Path) -> Edge:
        """Give a connection that stands in a system as data flows through it."""
        ends = declared.ends
        kinds = [self._kind(node, declared) for node in ends]
        # What a system takes in from outside it gives to its inside.
        gives = [(kind in _GIVING) != (node.path == within) for kind, node in zip(kinds, ends, strict=True)]
        edge = replace(declared, source=ends[1], target=ends[0]) if gives[1] else declared
        source, target = reversed(kinds) if gives[1] else kinds
        parameters, remedy = ("parameter", "structuralParameter"), None
        if gives[0] == gives[1]:
            source, target = kinds
            remedy = "connect an output to an input"
        elif target in parameters and source not in parameters:
            remedy = "give the parameter a start value"
        elif source in parameters and (edge.source.path != within or target not in (*parameters, "input")):
            remedy = "give a start value instead"
        if remedy is not None:
            raise InputError(f"{declared}: {source} does not connect to {target}; {remedy}")
        return edge

    def _kind(self, node: Node, edge: Edge) -> str:
        if node.path not in self.elements:
            name, known = ".".join(node.path), [".".join(path) for path in self.components]
            raise InputError(f"{edge}: there is no component {name}; {instead(name, known, 'or add it')}")
        declared = self.declared(node)
        if declared is None:
            owner = ".".join(node.path) or "the system"
            raise InputError(
                f"{edge}: {owner} has no connector {node.connector}; declare it or correct the name"
            )
        return declared.kind


def net_of(system: System, nested: bool = False) -> Net:
    """Net of a system: the reverse of making it flat.

    In a `nested` one each name before a dot is that of a system, and InputError if that of a component too. A
    connection from one inner system into another is a chain through connectors of the systems on the way.
    """
    net = Net()
    net.add((), Element())
    paths = {name: tuple(name.split(".")) if nested else (name,) for name in system.components}
    for name, held in system.components.items():
        path = paths[name]
        for outer in (path[:depth] for depth in range(1, len(path))):
            if net.elements.setdefault(outer, Element()).fmu is not None:
                raise InputError(f"{name}: {outer[-1]} is a component and cannot be a system; rename one")
        if path in net.elements:
            raise InputError(f"{name}: is a component and a system; rename one")
        chosen = replace(Element(), implementation=held.implementation, values=held.values)
        net.add(path, replace(chosen, connectors=dict(held.connectors), fmu=held.fmu))
    for link in system.connections:
        _lay(net, link, *(paths.get(name, (name,)) for name, _ in link.ends))
    return net


def _lay(net: Net, link: Connection, start: Path, end: Path) -> None:
    """Lay a connection through the net: out of the source's systems, across, into the target's."""
    steps = zip(start[:-1], end[:-1], strict=False)
    shared = len(list(takewhile(lambda pair: pair[0] == pair[1], steps)))
    giving = Node(start, link.source_variable)
    for depth in range(len(start) - 1, shared, -1):
        name = "_".join((*start[depth:], link.source_variable))
        giving = _passed(net, giving, start[:depth], start[:depth], "output", name)
    for depth in range(shared, len(end) - 1):
        name = "_".join((*end[depth + 1 :], link.target_variable))
        giving = _passed(net, giving, end[:depth], end[: depth + 1], "input", name)
    last = replace(edge_of(link), source=giving, target=Node(end, link.target_variable))
    net.elements[end[:-1]].connections.append(last)


def _passed(net: Net, giving: Node, within: Path, to: Path, kind: str, name: str) -> Node:
    """Connector of the system `to` that passes a value on, connected in another one where it is not yet."""
    connections, known = net.elements[within].connections, net.elements[to].connectors
    for edge in connections:
        if edge.source == giving and edge.target.path == to:
            return edge.target
    while name in known:
        name += "_"
    known[name] = replace(net.elements[giving.path].connectors[giving.connector], kind=kind)
    connections.append(Edge(giving, Node(to, name)))
    return connections[-1].target

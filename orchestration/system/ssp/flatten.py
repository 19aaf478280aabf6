"""Nested systems made flat: components under dotted names, and who drives whom through all connectors."""

from __future__ import annotations

from dataclasses import dataclass, field

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.system.ssp.declared import (
    DeclaredComponent,
    DeclaredConnection,
    DeclaredConnector,
    DeclaredSystem,
)
from warmlink.orchestration.system.units import Conversion

Path = tuple[str, ...]

# As seen from the system around an element; of a system's own connectors its inside sees the reverse.
_GIVING = ("output", "calculatedParameter", "local", "constant")

_MOST_ELEMENTS = 100_000


@dataclass(frozen=True)
class Node:
    """A connector of a component or of a system, by the names on the way to it."""

    path: Path
    connector: str

    def __str__(self) -> str:
        return ".".join((*self.path, self.connector))


@dataclass(frozen=True)
class Edge:
    """A connection as data flows through it."""

    source: Node
    target: Node
    transformation: Conversion | None
    suppress_unit_conversion: bool

    def __str__(self) -> str:
        return f"{self.source} -> {self.target}"


@dataclass
class Flat:
    """All components and systems of a tree by path, and the edges between their connectors.

    Parameters
    ----------
    into
        For each taking connector the one edge that ends there.
    out_of
        For each giving connector the edges that begin there, in the order written.
    """

    components: dict[Path, DeclaredComponent] = field(default_factory=dict)
    systems: dict[Path, DeclaredSystem] = field(default_factory=dict)
    into: dict[Node, Edge] = field(default_factory=dict)
    out_of: dict[Node, list[Edge]] = field(default_factory=dict)

    def connector(self, node: Node) -> DeclaredConnector | None:
        """Give a connector's declaration, or None where there is none."""
        owner = self.components.get(node.path) or self.systems.get(node.path)
        return None if owner is None else owner.connectors.get(node.connector)

    def way_to(self, node: Node) -> list[Edge]:
        """Give the edges from whatever drives a connector up to it, in the order of the data's flow."""
        way: list[Edge] = []
        seen = {node}
        while edge := self.into.get(node):
            way.insert(0, edge)
            node = edge.source
            if node in seen:
                raise InputError(f"{edge}: the connectors of systems drive each other in a circle")
            seen.add(node)
        return way


def flatten(system: DeclaredSystem) -> Flat:
    """Give all components and the directed edges of a tree of systems.

    InputError where a connection ends nowhere, joins two ends of one direction, or is the second into its
    target, or where two components get the same dotted name.
    """
    flat = Flat()
    _collect(system, (), flat)
    names: set[str] = set()
    for path in flat.components:
        name = ".".join(path)
        if name in names:
            raise InputError(f"{name}: is the name of two components once systems are flat; rename one")
        names.add(name)
    for path, inner in flat.systems.items():
        for connection in inner.connections:
            _add(_directed(connection, path, flat), flat)
    return flat


def _collect(system: DeclaredSystem, path: Path, flat: Flat) -> None:
    if len(flat.components) + len(flat.systems) > _MOST_ELEMENTS:
        raise InputError(f"{path[0]}: the system has more than {_MOST_ELEMENTS} elements, which none needs")
    flat.systems[path] = system
    for name, element in system.elements.items():
        inner = (*path, name)
        if isinstance(element, DeclaredSystem):
            _collect(element, inner, flat)
        else:
            flat.components[inner] = element


def _add(edge: Edge, flat: Flat) -> None:
    first = flat.into.get(edge.target)
    if first is not None:
        raise InputError(
            f"{edge}: {edge.target} is driven by {first.source} already; one connection may enter an input"
        )
    flat.into[edge.target] = edge
    flat.out_of.setdefault(edge.source, []).append(edge)


def _directed(connection: DeclaredConnection, path: Path, flat: Flat) -> Edge:
    start = _node(path, connection.start_element, connection.start_connector)
    end = _node(path, connection.end_element, connection.end_connector)
    between = f"{start} -> {end}"
    kinds = [_kind(node, flat, between) for node in (start, end)]
    # What a system takes in from outside it gives to its inside.
    gives = [(kind in _GIVING) != (node.path == path) for kind, node in zip(kinds, (start, end), strict=True)]
    if gives[0] == gives[1]:
        raise InputError(
            f"{between}: {kinds[0]} does not connect to {kinds[1]}; connect an output to an input"
        )
    source, target = (start, end) if gives[0] else (end, start)
    source_kind, target_kind = kinds if gives[0] else (kinds[1], kinds[0])
    _refuse_kinds(source_kind, target_kind, source.path == path, between)
    return Edge(source, target, connection.transformation, connection.suppress_unit_conversion)


def _refuse_kinds(source: str, target: str, from_system: bool, between: str) -> None:
    parameters = ("parameter", "structuralParameter")
    if target in parameters and source not in parameters:
        raise InputError(
            f"{between}: {source} does not connect to {target}; give the parameter a start value"
        )
    if source in parameters and not (from_system and target in (*parameters, "input")):
        raise InputError(f"{between}: {source} does not connect to {target}; give a start value instead")


def _node(path: Path, element: str | None, connector: str) -> Node:
    return Node(path if element is None else (*path, element), connector)


def _kind(node: Node, flat: Flat, between: str) -> str:
    declared = flat.connector(node)
    if declared is not None:
        return declared.kind
    if node.path not in flat.components and node.path not in flat.systems:
        name, known = ".".join(node.path), [".".join(path) for path in flat.components]
        raise InputError(f"{between}: there is no component {name}; {instead(name, known, 'or add it')}")
    owner = ".".join(node.path) or "the system"
    raise InputError(f"{between}: {owner} has no connector {node.connector}; declare it or correct the name")

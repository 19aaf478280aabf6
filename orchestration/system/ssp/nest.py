"""A system as a tree: each name before a dot is a system of its own, in which the components stand.

The reverse of `flatten`: a connection from one inner system into another becomes a chain through connectors
that the systems on the way show.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.model import Component, Connection, System
from warmlink.orchestration.system.ssp.declared import DeclaredConnection

Path = tuple[str, ...]
End = tuple[str, str]
"""Name of a component and of one of its variables."""


@dataclass(frozen=True)
class SystemConnector:
    """A connector of an inner system: it carries the values of `source`, hence its type and unit."""

    name: str
    kind: Literal["input", "output"]
    source: End


@dataclass
class Tree:
    """A system with its components by the names that they bear in it, and the systems in it."""

    components: dict[str, Component] = field(default_factory=dict)
    systems: dict[str, Tree] = field(default_factory=dict)
    connectors: list[SystemConnector] = field(default_factory=list)
    edges: list[DeclaredConnection] = field(default_factory=list)


def flat(system: System) -> Tree:
    """Give a tree of one system, with the components under their full names."""
    edges = [DeclaredConnection.of(link) for link in system.connections]
    return Tree(components=dict(system.components), edges=edges)


def nested(system: System) -> Tree:
    """Give the tree that the dots in the names tell of; no name may be a component's and a system's."""
    top = Tree()
    for name, held in system.components.items():
        *way, last = name.split(".")
        place = top
        for step in way:
            if step in place.components:
                raise InputError(f"{name}: {step} is a component and cannot be a system; rename one")
            place = place.systems.setdefault(step, Tree())
        if last in place.systems:
            raise InputError(f"{name}: is a component and a system; rename one")
        place.components[last] = held
    for link in system.connections:
        _connect(top, link)
    return top


def _connect(top: Tree, link: Connection) -> None:
    """Lay a connection through the tree: out of the source's systems, across, into the target's."""
    start, end = link.source_component.split("."), link.target_component.split(".")
    shared = 0
    while start[:-1][: shared + 1] == end[:-1][: shared + 1] and shared < min(len(start), len(end)) - 1:
        shared += 1
    source: End = (link.source_component, link.source_variable)
    element, connector = start[-1], link.source_variable
    for depth in range(len(start) - 1, shared, -1):
        shown = _shown(_at(top, start[:depth]), "output", source, "_".join((*start[depth:], source[1])))
        _lay(_at(top, start[:depth]), DeclaredConnection(element, connector, None, shown))
        element, connector = start[depth - 1], shown
    giver: str | None = element
    for depth in range(shared, len(end) - 1):
        name = "_".join((*end[depth + 1 :], link.target_variable))
        shown = _shown(_at(top, end[: depth + 1]), "input", source, name)
        _lay(_at(top, end[:depth]), DeclaredConnection(giver, connector, end[depth], shown))
        giver, connector = None, shown
    last = DeclaredConnection.of(link)
    last = replace(last, start_element=giver, start_connector=connector, end_element=end[-1])
    _at(top, end[:-1]).edges.append(last)


def _at(top: Tree, path: list[str]) -> Tree:
    place = top
    for step in path:
        place = place.systems[step]
    return place


def _shown(place: Tree, kind: Literal["input", "output"], source: End, name: str) -> str:
    """Give the connector by which a system passes a source on, made where there is none yet."""
    for known in place.connectors:
        if (known.kind, known.source) == (kind, source):
            return known.name
    taken = {known.name for known in place.connectors}
    while name in taken:
        name += "_"
    place.connectors.append(SystemConnector(name, kind, source))
    return name


def _lay(place: Tree, edge: DeclaredConnection) -> None:
    if edge not in place.edges:
        place.edges.append(edge)

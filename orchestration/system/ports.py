"""Connectors: which a component shows, and which a system has that is to be part of a larger one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import get_args

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.flags import flag_of
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import Component, Connector, ConnectorKind, System
from warmlink.orchestration.system.ssp.declared import DeclaredConnection
from warmlink.orchestration.system.ssp.nest import End, SystemConnector, Tree, flat


@dataclass(frozen=True)
class Ports:
    """What a system exchanges with a larger one that holds it.

    Attributes
    ----------
    drivers : components to leave out; an input of the system takes the place of each of their outputs
    shown : components and outputs that outputs of the system pass on, as `("link", "elongation")`
    """

    drivers: tuple[str, ...]
    shown: tuple[End, ...]


def opened(system: System, ports: Ports) -> tuple[System, Tree]:
    """Give a system without its drivers, and its tree with the connectors that take their place."""
    kept = {name: held for name, held in system.components.items() if name not in ports.drivers}
    links = tuple(c for c in system.connections if c.source_component in kept)
    cut = [c for c in system.connections if c.source_component not in kept]
    inner = replace(system, components=kept, connections=links)
    tree = flat(inner)
    given = _names((c.source_component, c.source_variable) for c in cut)
    for link in cut:
        name = given[link.source_component, link.source_variable]
        target = (link.target_component, link.target_variable)
        if name not in {known.name for known in tree.connectors}:
            tree.connectors.append(SystemConnector(name, "input", target))
        tree.edges.append(replace(DeclaredConnection.of(link), start_element=None, start_connector=name))
    flags = [(name, flag_of(variable)) for name, variable in ports.shown]
    there = [(name, flag) for name, flag in flags if flag in read_description(kept[name].fmu).variables]
    for end, name in _names((*ports.shown, *there)).items():
        tree.connectors.append(SystemConnector(name, "output", end))
        tree.edges.append(DeclaredConnection(*end, None, name))
    return inner, tree


def with_connectors(system: System) -> System:
    """Give the system with connectors everywhere: those who read the file connect nothing else."""
    parts = {
        name: held if held.connectors else replace(held, connectors=_connectors(held, system))
        for name, held in system.components.items()
    }
    for link in system.connections:
        for name, connector in (
            (link.source_component, link.source_variable),
            (link.target_component, link.target_variable),
        ):
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
        for kind in get_args(ConnectorKind)
        if kind == v.causality
        and v.kind is not None
        and not v.dimensions
        and (kind == "output" or v.name in (used if kind == "input" else held.values))
    )


def _names(ends: Iterable[End]) -> dict[End, str]:
    """Name of the connector for each end: its variable's, with the component's where two would be equal."""
    found = list(dict.fromkeys(ends))
    variables = [variable for _, variable in found]
    return {
        (component, variable): variable if variables.count(variable) == 1 else f"{component}_{variable}"
        for component, variable in found
    }

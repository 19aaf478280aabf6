"""Building a system in code from FMU files, with the same checks as for one that is read from an SSP."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import cast, get_args

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.system.check import checked_value, variable_of
from warmlink.orchestration.system.description import ModelInfo, read_description
from warmlink.orchestration.system.model import (
    Component,
    Connection,
    ConnectorKind,
    System,
    Value,
)
from warmlink.orchestration.system.ssp.declared import (
    DeclaredComponent,
    DeclaredConnection,
    DeclaredConnector,
    DeclaredSystem,
)
from warmlink.orchestration.system.ssp.flatten import Path as ElementPath
from warmlink.orchestration.system.ssp.flatten import flatten
from warmlink.orchestration.system.ssp.resolve import Resolver
from warmlink.orchestration.system.units import Unit


def component(name: str, fmu: Path, values: Mapping[str, Value] | None = None) -> Component:
    """Give a component of a system; writing lists as its connectors what is connected, set, or put out.

    Parameters
    ----------
    name
        The component's name in the system.
    fmu
        Path of the .fmu file.
    values
        Start values by variable name, in the variables' own units.

    Raises
    ------
    InputError
        If the FMU cannot be read or a value does not fit.
    """
    info = read_description(fmu)
    checked = {
        key: checked_value(variable_of(info, key, f"{name}.{key}"), value, f"{name}.{key}")
        for key, value in (values or {}).items()
    }
    return Component(name, fmu, values=checked)


def assemble(
    name: str,
    fmus: Mapping[str, str | Path],
    wires: Iterable[tuple[str, str]] = (),
    values: Mapping[str, Mapping[str, Value]] = MappingProxyType({}),
) -> System:
    """Make a system of FMU files.

    Parameters
    ----------
    name
        What the system is called.
    fmus
        The .fmu file of each component, by the component's name.
    wires
        Ends of each connection, as `("motor.heat_flow", "link.heat_flow")`; units are converted.
    values
        Start values by component and variable, in the variables' own units.

    Raises
    ------
    InputError
        If an FMU cannot be read, or something does not exist or does not fit.
    """
    parts = {each: component(each, Path(fmu), values.get(each)) for each, fmu in fmus.items()}
    for each in values:
        if each not in parts:
            raise InputError(f"{each}: there is no component of this name; {instead(each, parts)}")
    system = System(name, parts, tuple(connect(parts, source, target) for source, target in wires))
    check_system(system)
    return system


def connect(components: Mapping[str, Component], source: str, target: str) -> Connection:
    """Give the connection between two variables, with the conversion of their units.

    Parameters
    ----------
    components
        The system's components by name.
    source, target
        As `motor.heat_flow`; a component's name may hold dots.

    Raises
    ------
    InputError
        If an end does not exist, or kinds, types or quantities do not fit.
    """
    giver, giving = _end(components, source)
    taker, taking = _end(components, target)
    ends = {end.name: replace(end, connectors=()) for end in (giver, taker)}
    return _resolved(System("", ends, (Connection(giver.name, giving, taker.name, taking),)))[0]


def check_system(system: System) -> None:
    """Check a system against its FMUs, whoever made it.

    Raises
    ------
    InputError
        If a connector, start value or connection does not fit, or an input is driven twice.
    """
    for name, held in system.components.items():
        if name != held.name:
            raise InputError(f"{name}: the component calls itself {held.name}; give it one name")
        info = read_description(held.fmu)
        for key, value in held.values.items():
            checked_value(variable_of(info, key, f"{name}.{key}"), value, f"{name}.{key}")
    for link, found in zip(system.connections, _resolved(system), strict=True):
        if found != link:
            raise InputError(
                f"{link.source} -> {link.target}: the units differ by a factor {found.factor:g} and an "
                f"offset {found.offset:g}; give them to the connection"
            )


def _resolved(system: System) -> list[Connection]:
    """Give a system's connections with the conversion of their units, as if an SSD had declared them."""
    infos: dict[ElementPath, ModelInfo] = {}
    elements: dict[str, DeclaredComponent | DeclaredSystem] = {}
    for name, held in system.components.items():
        infos[name,] = read_description(held.fmu)
        elements[name] = _declared(system, held, infos[name,])
    links = tuple(map(DeclaredConnection.of, system.connections))
    resolver = Resolver(flatten(DeclaredSystem(system.name, {}, (), elements, links)), infos)
    for place in resolver.flat.components:
        resolver.connectors(place)
    return list(resolver.connections())


def _declared(system: System, held: Component, info: ModelInfo) -> DeclaredComponent:
    """Give a component's declaration, with connectors for the ends of connections that it does not show."""
    units, kinds = system.units, cast("tuple[ConnectorKind, ...]", get_args(ConnectorKind))
    shown = {
        c.name: DeclaredConnector(c.name, c.kind, c.type, units.get(c.unit, Unit(c.unit)) if c.unit else None)
        for c in held.connectors
    }
    given = [c.source_variable for c in system.connections if c.source_component == held.name]
    taken = [c.target_variable for c in system.connections if c.target_component == held.name]
    for end in given + taken:
        variable = variable_of(info, end, f"{held.name}.{end}")
        # Time, which is of no kind, connects to nothing, as a parameter does.
        kind: ConnectorKind = next((k for k in kinds if k == variable.causality), "parameter")
        shown.setdefault(end, DeclaredConnector(end, kind, None, None))
    return DeclaredComponent(held.name, held.fmu, shown, ())


def _end(components: Mapping[str, Component], name: str) -> tuple[Component, str]:
    owners = [owner for owner in components if name.startswith(f"{owner}.")]
    if not owners:
        raise InputError(f"{name}: there is no component of this name; {instead(name, components)}")
    owner = max(owners, key=len)
    return components[owner], name[len(owner) + 1 :]

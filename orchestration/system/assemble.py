"""Building a system in code from FMU files, with the same checks as for one that is read from an SSP."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.system.check import check_kind, checked_value, own_unit, variable_of
from warmlink.orchestration.system.description import ModelInfo, Variable, read_description
from warmlink.orchestration.system.model import (
    Component,
    Connection,
    Connector,
    ParameterSet,
    System,
    Value,
)
from warmlink.orchestration.system.units import Unit, fitting

_OUTGOING = ("output", "calculatedParameter", "local", "constant")


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
    return Component(name, fmu, parameters=ParameterSet(values=checked))


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
    link = Connection(giver.name, giving, taker.name, taking)
    factor, offset = _needed(giver, taker, link)
    return Connection(giver.name, giving, taker.name, taking, factor, offset)


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
        for connector in held.connectors:
            _check_connector(info, connector, f"{name}.{connector.name}")
        for key, value in held.parameters.values.items():
            checked_value(variable_of(info, key, f"{name}.{key}"), value, f"{name}.{key}")
    driven: dict[str, Connection] = {}
    for link in system.connections:
        _check_connection(system, link)
        first = driven.setdefault(link.target, link)
        if first is not link:
            raise InputError(
                f"{link.source} -> {link.target}: {link.target} is driven by {first.source} already; "
                "one connection may enter an input"
            )


def _check_connector(info: ModelInfo, connector: Connector, where: str) -> None:
    variable = variable_of(info, connector.name, where)
    check_kind(variable, connector.kind, where)
    if connector.type != variable.kind:
        raise InputError(f"{where}: is declared {connector.type}, but the FMU's variable is {variable.type}")
    if connector.unit is not None and variable.unit not in (None, connector.unit):
        raise InputError(
            f"{where}: is declared in {connector.unit}, but the FMU's variable is in {variable.unit}; "
            "correct one"
        )


def _check_connection(system: System, link: Connection) -> None:
    for name in (link.source_component, link.target_component):
        if name not in system.components:
            raise InputError(
                f"{link.source} -> {link.target}: there is no component {name}; "
                f"{instead(name, system.components, 'or add it')}"
            )
    explicit = (link.factor, link.offset) != (1.0, 0.0)
    giver, taker = system.components[link.source_component], system.components[link.target_component]
    needed = _needed(giver, taker, link, explicit)
    if not explicit and needed != (1.0, 0.0):
        raise InputError(
            f"{link.source} -> {link.target}: the units differ by a factor {needed[0]:g} and an offset "
            f"{needed[1]:g}; give them to the connection"
        )


def _needed(
    giver: Component, taker: Component, link: Connection, explicit: bool = False
) -> tuple[float, float]:
    """Give the factor and offset between the units of two ends, having checked that the ends fit."""
    between = f"{link.source} -> {link.target}"
    giving, unit = _variable(giver, link.source_variable)
    taking, target_unit = _variable(taker, link.target_variable)
    if giving.causality not in _OUTGOING or taking.causality != "input":
        raise InputError(
            f"{between}: {giving.causality} does not connect to {taking.causality}; "
            "connect an output to an input"
        )
    if giving.kind != taking.kind:
        raise InputError(
            f"{between}: {giving.kind} does not convert to {taking.kind}; connect variables of one type"
        )
    if explicit or unit is None or target_unit is None:
        return 1.0, 0.0
    difference = giving.relative and taking.relative
    found = fitting(unit, target_unit, difference, between, "connect variables of one quantity")
    return found.factor, found.offset


def _variable(held: Component, name: str) -> tuple[Variable, Unit | None]:
    info = read_description(held.fmu)
    variable = variable_of(info, name, f"{held.name}.{name}")
    declared = next((c.unit for c in held.connectors if c.name == name), None)
    return variable, own_unit(info, variable, Unit(declared) if declared else None)


def _end(components: Mapping[str, Component], name: str) -> tuple[Component, str]:
    owners = [owner for owner in components if name.startswith(f"{owner}.")]
    if not owners:
        raise InputError(f"{name}: there is no component of this name; {instead(name, components)}")
    owner = max(owners, key=len)
    return components[owner], name[len(owner) + 1 :]

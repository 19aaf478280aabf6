"""An SSD as it is written: a tree of systems and components, before anything is resolved or checked."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from warmlink.orchestration.system.model import Connection, ConnectorKind, DefaultExperiment
from warmlink.orchestration.system.ssp.parameter_values import MappingEntry, Parameter
from warmlink.orchestration.system.units import Conversion, Unit


@dataclass(frozen=True)
class DeclaredConnector:
    """A connector as written: `type` is SSP's name of it, None where none is given; `sizes` of an array."""

    name: str
    kind: ConnectorKind
    type: str | None
    unit: Unit | None
    sizes: tuple[int, ...] = ()


@dataclass(frozen=True)
class Binding:
    """One parameter binding: values, with the prefix applied, and the mapping of names if there is one."""

    parameters: tuple[Parameter, ...]
    mapping: tuple[MappingEntry, ...] | None
    where: str


@dataclass(frozen=True)
class DeclaredConnection:
    """A connection as written; an element None is the enclosing system itself."""

    start_element: str | None
    start_connector: str
    end_element: str | None
    end_connector: str
    transformation: Conversion | None = None
    suppress_unit_conversion: bool = False

    @classmethod
    def of(cls, link: Connection) -> DeclaredConnection:
        """Declare a connection between components, in the units of their own variables."""
        ends = link.source_component, link.source_variable, link.target_component, link.target_variable
        return cls(*ends, Conversion(link.factor, link.offset) if link.converts else None, link.converts)


@dataclass(frozen=True)
class DeclaredComponent:
    """A component that names an FMU."""

    name: str
    fmu: Path
    connectors: dict[str, DeclaredConnector]
    bindings: tuple[Binding, ...]


@dataclass(frozen=True)
class DeclaredSystem:
    """A system with its elements in the order written."""

    name: str
    connectors: dict[str, DeclaredConnector]
    bindings: tuple[Binding, ...]
    elements: dict[str, DeclaredComponent | DeclaredSystem] = field(default_factory=dict)
    connections: tuple[DeclaredConnection, ...] = ()


@dataclass(frozen=True)
class Description:
    """A whole SSD."""

    name: str
    system: DeclaredSystem
    default_experiment: DefaultExperiment
    units: dict[str, Unit]

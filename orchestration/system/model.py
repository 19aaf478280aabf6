"""A system of co-simulation components: what is wired to what, and which start values apply.

This is the one form that every SSP is read into and that the master runs. Nested systems are
flattened on reading; a component then bears its full dotted name.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from warmlink.orchestration.console import Answer
from warmlink.orchestration.system.units import Unit

ConnectorKind = Literal[
    "input", "output", "parameter", "calculatedParameter", "structuralParameter", "local", "constant"
]
ConnectorType = Literal["Real", "Integer", "Boolean", "String", "Enumeration"]
Value = float | int | bool | str


@dataclass(frozen=True)
class Connector:
    """A variable of a component as the system sees it; `unit` is None where the SSP gives none."""

    name: str
    kind: ConnectorKind
    type: ConnectorType = "Real"
    unit: str | None = None


@dataclass(frozen=True)
class Component:
    """One FMU in the system: its file, its connectors, and start values in its variables' own units."""

    name: str
    fmu: Path
    connectors: tuple[Connector, ...] = ()
    values: dict[str, Value] = field(default_factory=dict)


@dataclass(frozen=True)
class Connection:
    """From an output to an input: `target = factor * source + offset` in the two variables' own units."""

    source_component: str
    source_variable: str
    target_component: str
    target_variable: str
    factor: float = 1.0
    offset: float = 0.0

    @property
    def converts(self) -> bool:
        """Whether the target is anything but the source itself."""
        return (self.factor, self.offset) != (1.0, 0.0)

    @property
    def source(self) -> str:
        """Both names of the giving end, as `link.elongation`."""
        return f"{self.source_component}.{self.source_variable}"

    @property
    def target(self) -> str:
        """Both names of the taking end, as `camera.elongation`."""
        return f"{self.target_component}.{self.target_variable}"


@dataclass(frozen=True)
class DefaultExperiment:
    """Times in s that the system proposes for itself; None where it proposes nothing."""

    start_time: float = 0.0
    stop_time: float | None = None
    step_size: float | None = None


@dataclass(frozen=True, repr=False)
class System(Answer):
    """Components by name, in the order given, and the connections between them.

    Parameters
    ----------
    units
        Definitions of those connector units that no FMU of the system defines itself.
    remarks
        What the standard lets a reader pass over and a person should hear of, one sentence each.
    """

    name: str
    components: dict[str, Component]
    connections: tuple[Connection, ...] = ()
    default_experiment: DefaultExperiment = DefaultExperiment()
    units: dict[str, Unit] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()

    def summary(self) -> str:
        """Name, components and number of connections."""
        return f"{self.name}: {', '.join(self.components)}; {len(self.connections)} connections"

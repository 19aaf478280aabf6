"""What a scenario runs in: a system, and what a scenario has to know of it beside its parts and wires."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warmlink.fmus.component import Component
from warmlink.orchestration import catalogue
from warmlink.orchestration.scenarios.expression import Expression
from warmlink.orchestration.system.model import Value
from warmlink.orchestration.system.shipped import COMPENSATOR, WARMUP_CELL, Blueprint

if TYPE_CHECKING:
    from warmlink.orchestration.master.recording.result import Result

StartValues = Mapping[str, Mapping[str, Value]]
"""Start values in SI units by instance and variable."""

THERMOMETERS, CHANNELS = "TemperatureSensors", 8


@dataclass(frozen=True)
class Roles:
    """Who does what in a system.

    Attributes
    ----------
    score : error of the tool point in m, an expression over the system's variables
    uncompensated : what it would be without a controller
    plant : variables whose coupling error is stated; the largest counts
    """

    score: Expression
    uncompensated: Expression
    plant: tuple[str, ...]

    @classmethod
    def scored_by(cls, score: str, uncompensated: str, plant: tuple[str, ...] | None = None) -> Roles:
        """Roles from the texts of the expressions; what is left out follows from them."""
        without = Expression(uncompensated, "uncompensated")
        return cls(Expression(score), without, plant or without.variables)


@dataclass(frozen=True)
class Sensors:
    """What the controllers go by: noise (1 sigma) in K, and which temperatures; None: as they are."""

    noise: float | None = None
    used: tuple[str, ...] | None = None


AS_THEY_ARE = Sensors()

Designs = Callable[[str, Sensors], StartValues | None]
"""Start values of the controllers made for a system, by the law's name; None where it has no design."""


@dataclass(frozen=True)
class Setup:
    """A system that scenarios run in.

    Attributes
    ----------
    blueprint : parts and wires; parts without a component take the controller
    values : what differs from the start values that the parts declare
    sensors : what the controllers go by unless the scenario says otherwise
    designs : parameters of the laws for this system; None where those that the laws ship with are for it
    foreign : FMUs that came with the system, by the name of the component in the blueprint
    detail : figures of a run that the system has besides, for `uncompensated` and `compensated`
    """

    blueprint: Blueprint
    roles: Roles
    values: StartValues = field(default_factory=dict)
    sensors: Sensors = AS_THEY_ARE
    designs: Designs | None = None
    foreign: Mapping[str, Path] = field(default_factory=dict)
    detail: Callable[[Result], Mapping[str, Mapping[str, Any]]] | None = None

    @property
    def name(self) -> str:
        """Name of the system."""
        return self.blueprint.name

    @property
    def controllers(self) -> tuple[str, ...]:
        """Instances that take the controller."""
        return tuple(instance for instance, kind in self.blueprint.components.items() if not kind)

    @property
    def corrections(self) -> tuple[str, ...]:
        """What the controllers correct by."""
        return tuple(f"{instance}.correction" for instance in self.controllers)

    @property
    def kinds(self) -> set[str]:
        """Names of our components that the system needs, its controllers apart."""
        return {kind for kind in self.blueprint.components.values() if kind} - self.foreign.keys()

    def declared(self, law: Component) -> dict[str, Component]:
        """Declaration behind each instance that is one of ours."""
        known = {**catalogue.components(), law.name: law}
        kinds = self.blueprint.components_with(law.name)
        return {instance: known[kind] for instance, kind in kinds.items() if kind not in self.foreign}

    def called(self, short: str) -> list[str]:
        """Instances that are what one of the warm-up cell's is, as all motors are for `motor`."""
        kind = WARMUP_CELL.components.get(short)
        return [instance for instance, each in self.blueprint.components.items() if each == kind]

    def noisy(self, noise: float) -> dict[str, dict[str, Value]]:
        """Start values of the thermometers that give their readings a noise in K (1 sigma)."""
        channels = {f"noise[{channel}]": noise for channel in range(1, CHANNELS + 1)}
        return {each: {**channels, "seed": i} for i, each in enumerate(self.called("sensors"), start=1)}


CELL = Setup(WARMUP_CELL, Roles.scored_by(f"link.elongation - {COMPENSATOR}.correction", "link.elongation"))
"""The warm-up cell: one motor, one link."""


def merged(*parts: StartValues) -> dict[str, dict[str, Value]]:
    """Start values of several sources as one, later ones winning."""
    values: dict[str, dict[str, Value]] = {}
    for part in parts:
        for instance, chosen in part.items():
            values.setdefault(instance, {}).update(chosen)
    return values

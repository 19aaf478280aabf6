"""The system that a scenario runs in: its parts and wires, the roles of its variables, its sensors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from warmlink.controllers.interface import SENSED
from warmlink.fmus.component import Component
from warmlink.fmus.records import dataclass
from warmlink.orchestration import catalogue
from warmlink.orchestration.scenarios.entries import Names, Quantity
from warmlink.orchestration.scenarios.expression import Expression
from warmlink.orchestration.scenarios.written import TABLE
from warmlink.orchestration.system.model import StartValues, Value
from warmlink.orchestration.system.shipped import COMPENSATOR, WARMUP_CELL, Blueprint

if TYPE_CHECKING:
    from warmlink.orchestration.master.recording.result import Result

TEMPERATURES = tuple(each.removesuffix("_temperature") for each in SENSED)
THERMOMETERS, CHANNELS = "TemperatureSensors", 8


@dataclass(frozen=True)
class Roles:
    """Roles of a system's variables: their `score` is the error of the tool point in m.

    `uncompensated` is the same error without a controller; of the coupling errors of the `plant`'s variables
    the largest is reported.
    """

    score: Expression
    uncompensated: Expression
    plant: tuple[str, ...]


@dataclass(frozen=True)
class Sensors:
    """Thermometers that controllers use: noise (1 sigma), and which; None: as the system has them."""

    __pydantic_config__ = TABLE

    noise: Annotated[float | None, Quantity("K", least=0, difference=True)] = None
    used: Annotated[tuple[str, ...] | None, Names("base", TEMPERATURES)] = None


AS_THEY_ARE = Sensors()

Designs = Callable[[str, Sensors], StartValues | None]
"""Function that returns the controllers' start values for a system by the law's name, or None."""


@dataclass(frozen=True)
class Setup:
    """A system that scenarios run in.

    Attributes
    ----------
    blueprint : parts and wires; a part without a component is a place for the controller
    values : start values that differ from those that the parts declare
    sensors : thermometers that the controllers use unless the scenario says otherwise
    designs : parameters of the laws for this system; None if the shipped laws were designed for it
    foreign : FMUs that came with the system, by the name of the component in the blueprint
    detail : additional figures of a run of this system, for `uncompensated` and `compensated`
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
        """Instances that are replaced by the controller."""
        return tuple(instance for instance, kind in self.blueprint.components.items() if not kind)

    @property
    def corrections(self) -> tuple[str, ...]:
        """Names of the controllers' outputs that correct the error."""
        return tuple(f"{instance}.correction" for instance in self.controllers)

    @property
    def kinds(self) -> set[str]:
        """Names of warmlink's components that the system needs, without the controllers."""
        return {kind for kind in self.blueprint.components.values() if kind} - self.foreign.keys()

    @cached_property
    def reduced(self) -> Mapping[str, Component]:
        """Links that `warmlink reduce` made, among the FMUs that came with the system."""
        found = {kind: catalogue.reduced_link_in(path) for kind, path in self.foreign.items()}
        return {kind: each for kind, each in found.items() if each is not None}

    @property
    def unknown(self) -> set[str]:
        """Components of which only the FMU is known."""
        return self.foreign.keys() - self.reduced.keys()

    def declared(self, law: Component) -> dict[str, Component]:
        """Declaration of each instance that is a component of warmlink."""
        known = {**catalogue.components(), **self.reduced, law.name: law}
        kinds = self.blueprint.components_with(law.name)
        return {instance: known[kind] for instance, kind in kinds.items() if kind in known}

    def called(self, short: str) -> list[str]:
        """Instances that correspond to one of the warm-up cell's: for `motor` all motors."""
        kinds = {WARMUP_CELL.components.get(short), *(self.reduced if short == "link" else ())}
        return [instance for instance, each in self.blueprint.components.items() if each in kinds]

    def noisy(self, noise: float) -> dict[str, dict[str, Value]]:
        """Start values of the thermometers that give their readings a noise in K (1 sigma)."""
        channels = {f"noise[{channel}]": noise for channel in range(1, CHANNELS + 1)}
        return {each: {**channels, "seed": i} for i, each in enumerate(self.called("sensors"), start=1)}


_GROWTH = "link.elongation"
_CORRECTED = Expression(f"{_GROWTH} - {COMPENSATOR}.correction")

CELL = Setup(WARMUP_CELL, Roles(_CORRECTED, Expression(_GROWTH, "uncompensated"), (_GROWTH,)))
"""The warm-up cell: one motor, one link."""


def merged(*parts: StartValues) -> dict[str, dict[str, Value]]:
    """Merge start values of several sources; later sources take precedence."""
    values: dict[str, dict[str, Value]] = {}
    for part in parts:
        for instance, chosen in part.items():
            values.setdefault(instance, {}).update(chosen)
    return values

"""The system that a scenario runs in: its parts and wires, the roles of its variables, its sensors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from typing import TYPE_CHECKING, Annotated, Any

from warmlink.controllers.interface import SENSED
from warmlink.fmus.records import dataclass
from warmlink.orchestration.scenarios.entries import Names, Quantity
from warmlink.orchestration.scenarios.expression import Expression
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
    detail : additional figures of a run of this system, for `uncompensated` and `compensated`
    """

    blueprint: Blueprint
    roles: Roles
    values: StartValues = field(default_factory=dict)
    sensors: Sensors = AS_THEY_ARE
    designs: Designs | None = None
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

    def noisy(self, noise: float) -> dict[str, dict[str, Value]]:
        """Start values of the thermometers that give their readings a noise in K (1 sigma)."""
        channels = {f"noise[{channel}]": noise for channel in range(1, CHANNELS + 1)}
        called = self.blueprint.called("sensors")
        return {each: {**channels, "seed": i} for i, each in enumerate(called, start=1)}


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

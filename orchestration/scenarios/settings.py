"""What a scenario file says beside what drives the system."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated

from warmlink.controllers.interface import SENSED
from warmlink.orchestration.own_law import controller_named
from warmlink.orchestration.scenarios.entries import Names, Quantity, Text, Value
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.scenarios.setup import CELL, Sensors
from warmlink.orchestration.scenarios.written import TABLE

TEMPERATURES = tuple(each.removesuffix("_temperature") for each in SENSED)


@dataclass(frozen=True)
class SensorsTable:
    """What the controllers go by: noise of a reading (1 sigma), and which temperatures."""

    __pydantic_config__ = TABLE

    noise: Annotated[float | None, Quantity("K", least=0, difference=True)] = None
    used: Annotated[tuple[str, ...] | None, Names("base", TEMPERATURES)] = None


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What any scenario file may say."""

    system: Annotated[str, Text(CELL.name)] = CELL.name
    title: Annotated[str | None, Text()] = None
    about: Annotated[str | None, Text()] = None
    step_size: Annotated[float | None, Quantity("s", positive=True)] = None
    master: Annotated[str | None, Text("gauss_seidel")] = None
    controller: Annotated[str | None, Text("observer")] = None
    tolerance: Annotated[float | None, Quantity("m", positive=True)] = None
    parameters: Mapping[str, Annotated[str | float, Value()]] = field(default_factory=dict)
    sensors: SensorsTable = SensorsTable()

    def applied(self, default: Scenario) -> Scenario:
        """Scenario with what the file says; what it leaves out stays.

        Raises
        ------
        InputError
            If there is no such controller.
        """
        return replace(
            default,
            title=default.title if self.title is None else self.title,
            about=default.about if self.about is None else self.about,
            step_size=self.step_size or default.step_size,
            master=default.master if self.master is None else self.master,
            controller=default.controller if self.controller is None else controller_named(self.controller),
            tolerance=self.tolerance or default.tolerance,
            parameters=dict(self.parameters),
            sensors=Sensors(self.sensors.noise, self.sensors.used),
        )

"""Entries of a scenario file besides the duty cycle that drives the system."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace
from functools import cache
from pathlib import Path
from typing import Annotated

from warmlink.fmus.records import dataclass
from warmlink.orchestration.own_law import controller_named
from warmlink.orchestration.scenarios import mismatch
from warmlink.orchestration.scenarios.entries import Names, OneOf, Quantity, Text, Value
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.scenarios.setup import AS_THEY_ARE, CELL, Sensors
from warmlink.orchestration.text_files import read_toml

MATERIALS = Path(__file__).parent / "materials.toml"
_WORDS = ("about", "source")


@cache
def materials() -> dict[str, dict[str, str]]:
    """Materials by name: `about`, `source` and the values of their properties with units."""
    return read_toml(MATERIALS)


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
    coupling_tolerance: Annotated[float | None, Quantity("m", positive=True)] = None
    materials: Mapping[str, Annotated[str, OneOf(tuple(materials()))]] = field(default_factory=dict)
    parameters: Mapping[str, Annotated[str | float, Value()]] = field(default_factory=dict)
    mismatches: Annotated[tuple[str, ...], Names("draw_1")] = ()
    sensors: Sensors = AS_THEY_ARE

    def applied(self, default: Scenario) -> Scenario:
        """The scenario changed as the file says; what the file leaves out stays.

        Raises InputError if the controller or a mismatch does not exist.
        """
        names = ("title", "about", "step_size", "master", "tolerance", "coupling_tolerance")
        given = {name: value for name in names if (value := getattr(self, name)) is not None}
        if self.controller is not None:
            given["controller"] = controller_named(self.controller)
        of_materials = {
            f"{instance}.{name}": figure
            for instance, material in self.materials.items()
            for name, figure in materials()[material].items()
            if name not in _WORDS
        }
        scenario = replace(
            default, **given, parameters={**of_materials, **self.parameters}, sensors=self.sensors
        )
        for name in self.mismatches:
            scenario = mismatch.load(name).applied(scenario)
        return scenario

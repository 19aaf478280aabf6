"""Mismatches: how the real cell differs from the one that the controllers were designed for.

A mismatch is a TOML file with `about`, `[scale]` (factors on start values) and `[parameters]` (start values
with units), each under `instance.variable`. `draw_7` is drawn from the seed 7: every thermal parameter within
20 % and the expansion coefficient within 3 %, evenly.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead, listed
from warmlink.orchestration.machine.machine import Machine
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.scenarios.overrides import scalar, start_value
from warmlink.orchestration.text_files import is_file, read_toml
from warmlink.orchestration.written.entries import Number, Text, Values
from warmlink.orchestration.written.tables import Table, read_table

LIBRARY = Path(__file__).parent / "mismatches"

NOMINAL = "nominal"

THERMAL_PARAMETERS = (
    "motor.winding_heat_capacity",
    "motor.shaft_heat_capacity",
    "motor.winding_conductance",
    "motor.housing_conductance",
    "motor.joint_conductance",
    "link.conductivity",
    "link.specific_heat",
    "link.convection_still",
    "link.convection_per_speed",
)
EXPANSION = "link.expansion_coefficient"
THERMAL_SPREAD, EXPANSION_SPREAD = 0.20, 0.03
"""Largest relative error of a drawn thermal parameter, and of the expansion coefficient."""

Factor = Number("factor", above=0, at_most=1e6)

PLANT = ("duty", "motor", "link")
"""Instances that determine the true elongation."""

_DRAW = re.compile(r"draw_(\d{1,9})")


@dataclass(frozen=True)
class MismatchFile(Table):
    """How the real cell differs from the one that the controllers were designed for."""

    about: Annotated[str | None, Text()] = None
    scale: Mapping[str, Annotated[float, Factor]] = field(default_factory=dict)
    parameters: Values = field(default_factory=dict)


@dataclass(frozen=True)
class Mismatch:
    """Factors on start values and other start values, under `instance.variable`."""

    name: str
    about: str
    scale: Mapping[str, float] = field(default_factory=dict)
    parameters: Mapping[str, str | float] = field(default_factory=dict)

    @property
    def changes_nothing(self) -> bool:
        """Whether the real cell is the one that the controllers were designed for."""
        return not (self.scale or self.parameters)

    @property
    def touches_plant(self) -> bool:
        """Whether the true elongation differs from the nominal one."""
        named = (name.split(".")[:-1] for name in (*self.scale, *self.parameters))
        return any(part in PLANT for parts in named for part in parts)

    def on(
        self,
        parameters: Mapping[str, str | float],
        machine: Machine,
        components: Mapping[str, Component],
    ) -> dict[str, str | float]:
        """A machine's start values as written, changed by this mismatch.

        A change of the warm-up cell's motor applies to every motor of another machine, and so on; a factor
        multiplies the start value of each. Changes of parts that a machine does not have are left out.

        Raises InputError if the mismatch names a variable that does not exist, or a value that is no number.
        """
        where, changed = f"mismatch {self.name}", dict(parameters)
        for name, value in self.parameters.items():
            changed |= dict.fromkeys(_corresponding(name, machine), value)
        for name, factor in self.scale.items():
            for full in _corresponding(name, machine):
                instance, _, variable = full.rpartition(".")
                declared = scalar(full, components, where).start or 0.0
                base = float(machine.nominal.get(instance, {}).get(variable, declared))
                if full in changed:
                    base = start_value(full, changed[full], components, where)
                changed[full] = factor * base
        return changed


def _corresponding(name: str, machine: Machine) -> list[str]:
    """Variables of a system that a name of the warm-up cell stands for."""
    instance, _, variable = name.rpartition(".")
    if instance in machine.parts or instance not in WARMUP_CELL.parts:
        return [name]
    return [f"{each}.{variable}" for each in machine.called(instance)]


def together(mismatches: Sequence[Mismatch]) -> list[str]:
    """Sentences on what several mismatches change at once: by how much together, or which of them rules."""
    changing: dict[str, list[Mismatch]] = {}
    for each in mismatches:
        for name in {**each.parameters, **each.scale}:
            changing.setdefault(name, []).append(each)
    told = []
    for name, those in changing.items():
        by = listed([each.name for each in those])
        if len(those) > 1 and not any(name in each.parameters for each in those):
            told.append(
                f"{name}: {by} together make it {math.prod(m.scale[name] for m in those):.4g} times as large"
            )
        elif len(those) > 1 and name in those[-1].parameters:
            told.append(f"{name}: {by} all set it, and {those[-1].name} rules")
    return told


def names() -> list[str]:
    """Names of the mismatches in the library, without the random draws."""
    return sorted((path.stem for path in LIBRARY.glob("*.toml")), key=lambda name: (name != NOMINAL, name))


def load(name: str) -> Mismatch:
    """Mismatch from the library, from a TOML file by path, or drawn.

    Raises InputError if no mismatch has that name, or its file contains none.
    """
    drawn = _DRAW.fullmatch(name)
    if drawn:
        return draw(int(drawn.group(1)))
    path = Path(name) if name.endswith(".toml") else LIBRARY / f"{name}.toml"
    if not is_file(path):
        known = instead(name, [*names(), "draw_1", "draw_2"], "or give a TOML file")
        raise InputError(f"{name}: no such mismatch; {known}")
    return parsed(read_toml(path), path.stem)


def draw(seed: int) -> Mismatch:
    """Draw relative errors of the thermal parameters and the expansion coefficient, evenly, from a seed."""
    import numpy as np

    generator = np.random.default_rng(seed)
    spreads = {**dict.fromkeys(THERMAL_PARAMETERS, THERMAL_SPREAD), EXPANSION: EXPANSION_SPREAD}
    scale = {name: 1 + float(generator.uniform(-spread, spread)) for name, spread in spreads.items()}
    about = f"Thermal parameters wrong by up to 20 %, expansion by up to 3 %, drawn from seed {seed}"
    return Mismatch(f"draw_{seed}", about, scale)


def parsed(given: Mapping[str, Any], name: str) -> Mismatch:
    """Mismatch from the tables of its file; raises as `load`."""
    read = read_table(MismatchFile, given, name)
    return Mismatch(name, name if read.about is None else read.about, read.scale, read.parameters)

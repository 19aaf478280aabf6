"""What a study varies: one start value, between bounds or among choices."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

from warmlink.fmus.component import limits
from warmlink.fmus.errors import InputError
from warmlink.orchestration.scenarios.overrides import refuse_fed, scalar, start_value
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system.model import StartValues
from warmlink.orchestration.written.entries import Flag, Value
from warmlink.orchestration.written.tables import Table


@dataclass(frozen=True)
class AxisTable(Table):
    """Between which bounds a start value is varied, or among which values."""

    min: Annotated[str | float | None, Value()] = None
    max: Annotated[str | float | None, Value()] = None
    log: Annotated[bool, Flag()] = False
    values: tuple[Annotated[str | float, Value()], ...] | None = None

    def __post_init__(self) -> None:
        if self.values is None and (self.min is None or self.max is None):
            raise InputError('has no bounds; write { min = "...", max = "..." }')
        if self.values is not None and (self.log or self.min is not None or self.max is not None):
            raise InputError("has bounds and values; write { min = ..., max = ... } or { values = [...] }")
        if self.values == ():
            raise InputError("there is nothing to choose from; give values = [...]")


@dataclass(frozen=True)
class Axis:
    """One start value that is varied, in SI units: between both bounds, or among the values of `choice`.

    With `log` it is searched and spaced by its logarithm. `shipped` are the smallest and the largest value
    that it has without the study, since each scenario, and each axis of an arm, has one of its own.
    """

    name: str
    unit: str
    low: float
    high: float
    log: bool
    integer: bool
    choice: tuple[float, ...]
    shipped: tuple[float, float]

    @property
    def as_shipped(self) -> float | None:
        """The value by which nothing is changed; None where it cannot be chosen, or there are several."""
        least, _ = self.shipped
        if self.choice:
            near = min(self.choice, key=lambda value: abs(value - least))
        else:
            near = min(max(least, self.low), self.high)
        # What is written in another unit is rounded: 4.21 um/W are not quite 4.21e-6 m/W.
        return near if all(math.isclose(near, value, rel_tol=1e-9) for value in self.shipped) else None

    @property
    def heading(self) -> str:
        """Name with unit."""
        return f"{self.name} [{self.unit}]"

    @property
    def readable(self) -> tuple[str, float]:
        """Unit in which people read it, and the factor to it: `µm/W`, 1e6 for a gain of some 1e-6 m/W."""
        small = max(abs(self.low), abs(self.high)) < 1e-3 and re.match(r"[mWAVNKs](?!\w|\*)", self.unit)
        return (f"µ{self.unit}", 1e6) if small else (self.unit, 1.0)

    def shown(self, *values: float) -> str:
        """Values for people, as `2 to 8 µm/W`."""
        unit, factor = self.readable
        return f"{' to '.join(f'{factor * value:.6g}' for value in values)} {unit}".removesuffix(" 1")

    def at(self, share: float) -> float:
        """Value at a share of the way from the lower bound to the upper one, 0 to 1."""
        if self.choice:
            return self.choice[min(int(share * len(self.choice)), len(self.choice) - 1)]
        end = self.high + 1 if self.integer else self.high
        value = self.low * (end / self.low) ** share if self.log else self.low + share * (end - self.low)
        return min(max(float(math.floor(value)) if self.integer else value, self.low), self.high)

    def share(self, value: float) -> float:
        """Share of the way from the lower bound to the upper one, of an axis with bounds: undoes `at`."""
        if self.log:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def levels(self, count: int) -> list[float]:
        """Evenly spaced values from bound to bound, equal whole numbers once; all of a choice."""
        if self.choice:
            return list(self.choice)
        shares = [i / (count - 1) for i in range(count)] if count > 1 else [0.5]
        spaced = [replace(self, integer=False).at(share) for share in shares]
        return sorted({float(round(value)) for value in spaced}) if self.integer else spaced


def read_axis(
    name: str, table: AxisTable, scenarios: Sequence[tuple[Scenario, StartValues]], where: str
) -> Axis:
    """Axis from its table in a study file, and the study's scenarios with their start values without it.

    InputError where it, or a bound, does not fit the component, or it is an input that a wire feeds.
    """
    scenario, _ = scenarios[0]
    components = scenario.declared
    asked, name = name, scenario.machine.addressed(name)[0]
    found = scalar(name, components, where)
    place, unit = f"{where}: {name}", found.variable.unit
    refuse_fed(name, scenario.machine.fed, where)
    written = (table.min, table.max) if table.values is None else table.values
    values = [start_value(name, each, components, where) for each in written if each is not None]
    low, high = min(values), max(values)
    if table.values is None and not values[0] < values[1]:
        raise InputError(
            f"{place}: nothing lies between {values[0]:g} and {values[1]:g} {unit}; give a max above the min"
        )
    if table.log and not low > 0:
        raise InputError(f"{place}: log = true needs bounds above 0 {unit}; give such, or leave it out")
    for value in values:
        sentence = limits.problem(found, value)
        if sentence is not None:
            raise InputError(f"{where}: {name.partition('.')[0]}.{sentence}")
    choice = () if table.values is None else tuple(dict.fromkeys(values))
    shipped = [value for each, known in scenarios for value in _started(asked, each, known, where)]
    integer = found.variable.type != "Real"
    return Axis(asked, unit, low, high, table.log, integer, choice, (min(shipped), max(shipped)))


def _started(name: str, scenario: Scenario, known: StartValues, where: str) -> Iterator[float]:
    """Start values in a scenario of all variables that a name stands for."""
    for full in scenario.machine.addressed(name):
        instance, _, variable = full.rpartition(".")
        declared = scalar(full, scenario.declared, where).start or 0.0
        yield float(known.get(instance, {}).get(variable, declared))

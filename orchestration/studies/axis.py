"""What a study varies: a start value between two bounds, or among given values."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from warmlink.fmus.component import Component, limits
from warmlink.fmus.errors import InputError
from warmlink.orchestration.scenarios.entries import Flag, Value
from warmlink.orchestration.scenarios.overrides import scalar, start_value
from warmlink.orchestration.scenarios.written import TABLE


@dataclass(frozen=True)
class AxisTable:
    """Between which bounds a start value is varied, or among which values."""

    __pydantic_config__ = TABLE

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
    """One start value that is varied, in SI units.

    Attributes
    ----------
    name : as `compensator.gain`
    unit : SI unit
    low, high : bounds, both included
    log : whether to search and space it by its logarithm
    integer : whether it takes whole numbers alone
    choice : the values to choose from; empty if there are bounds
    shipped : start value that the component is shipped with
    """

    name: str
    unit: str
    low: float
    high: float
    log: bool
    integer: bool
    choice: tuple[float, ...]
    shipped: float

    @property
    def heading(self) -> str:
        """Name with unit, as `compensator.gain [m/W]`."""
        return f"{self.name} [{self.unit}]"

    @property
    def readable(self) -> tuple[str, float]:
        """Unit in which people read it, and the factor to it: `µm/W`, 1e6 for a gain of some 1e-6 m/W."""
        small = max(abs(self.low), abs(self.high)) < 1e-3 and re.match(r"[mWAVNKs](?!\w|\*)", self.unit)
        return (f"µ{self.unit}", 1e6) if small else (self.unit, 1.0)

    def shown(self, *values: float) -> str:
        """Values for people, as `2 to 8 µm/W`."""
        unit, factor = self.readable
        return f"{' to '.join(f'{factor * value:.6g}' for value in values)} {unit}"

    @property
    def holds_shipped(self) -> bool:
        """Whether the shipped value can be reached."""
        if self.choice:
            return self.shipped in self.choice
        return self.low <= self.shipped <= self.high

    def at(self, share: float) -> float:
        """Value at a share of the way from the lower bound to the upper one, 0 to 1."""
        if self.choice:
            return self.choice[min(int(share * len(self.choice)), len(self.choice) - 1)]
        if self.integer:
            return float(min(math.floor(self.low + share * (self.high - self.low + 1)), self.high))
        if self.log:
            return min(max(self.low * (self.high / self.low) ** share, self.low), self.high)
        return self.low + share * (self.high - self.low)

    def share(self, value: float) -> float:
        """Share of the way from the lower bound to the upper one, of an axis with bounds: undoes `at`."""
        if self.log:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def levels(self, count: int) -> list[float]:
        """Evenly spaced values from bound to bound; all of a choice."""
        if self.choice:
            return list(self.choice)
        if self.integer:
            span = self.high - self.low
            steps = max(1, min(count, int(span) + 1) - 1)
            return [float(round(self.low + span * i / steps)) for i in range(steps + 1)]
        return [self.at(i / (count - 1)) for i in range(count)] if count > 1 else [self.at(0.5)]


def read_axis(name: str, table: AxisTable, components: Mapping[str, Component], where: str) -> Axis:
    """Axis from its table in a study file; InputError where it, or a bound, does not fit the component."""
    found = scalar(name, components, where)
    place, unit = f"{where}: {name}", found.variable.unit
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
    integer = found.variable.type != "Real"
    return Axis(name, unit, low, high, table.log, integer, choice, float(found.start or 0.0))

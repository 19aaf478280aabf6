"""What a study varies: a start value between two bounds, or among given values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from warmlink.fmus.component import Component, limits
from warmlink.fmus.errors import InputError
from warmlink.orchestration.scenarios.overrides import scalar, start_value

_RANGE, _CHOICE = {"min", "max", "log"}, {"values"}


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
    choice : the values to choose from; empty where the bounds say it
    shipped : what it is where nobody sets it
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

    def levels(self, count: int) -> list[float]:
        """Evenly spaced values from bound to bound; all of a choice."""
        if self.choice:
            return list(self.choice)
        if self.integer:
            span = self.high - self.low
            steps = max(1, min(count, int(span) + 1) - 1)
            return [float(round(self.low + span * i / steps)) for i in range(steps + 1)]
        return [self.at(i / (count - 1)) for i in range(count)] if count > 1 else [self.at(0.5)]


def read_axis(name: str, table: Any, components: Mapping[str, Component], where: str) -> Axis:
    """Axis from its table in a study file.

    Raises
    ------
    InputError
        If there is no such parameter, a unit does not fit, the bounds are empty, or the component refuses
        a bound.
    """
    found = scalar(name, components, where)
    place = f"{where}: {name}"
    if not isinstance(table, Mapping) or not (set(table) <= _RANGE or set(table) <= _CHOICE):
        raise InputError(
            f'{place}: is no range; write {{ min = "...", max = "..." }} or {{ values = [...] }}'
        )
    choice = _choice(name, table, components, place, where)
    ends = [start_value(name, table[end], components, where) for end in ("min", "max") if end in table]
    if choice:
        low, high = min(choice), max(choice)
    elif len(ends) == 2:
        low, high = ends
    else:
        raise InputError(f'{place}: has no bounds; write {{ min = "...", max = "..." }}')
    unit = found.variable.unit
    if not choice and not low < high:
        raise InputError(
            f"{place}: nothing lies between {low:g} and {high:g} {unit}; give a max above the min"
        )
    log = table.get("log", False)
    if not isinstance(log, bool) or (log and not low > 0):
        raise InputError(f"{place}: log = {log} needs true or false, and bounds above 0 {unit}")
    for value in choice or (low, high):
        sentence = limits.problem(found, value)
        if sentence is not None:
            raise InputError(f"{where}: {name.partition('.')[0]}.{sentence}")
    integer = found.variable.type != "Real"
    return Axis(name, unit, low, high, log, integer, choice, float(found.start or 0.0))


def _choice(
    name: str, table: Mapping[str, Any], components: Mapping[str, Component], place: str, where: str
) -> tuple[float, ...]:
    if "values" not in table:
        return ()
    given = table["values"]
    if not isinstance(given, list) or not given:
        raise InputError(f"{place}: there is nothing to choose from; give values = [...]")
    return tuple(dict.fromkeys(start_value(name, value, components, where) for value in given))

"""Heat by an equation that a made-up run hides, as `shaft: a * max(speed - b, 0)**1.5; a = 1; b = 5 rpm`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from warmlink.fmus.errors import InputError
from warmlink.fmus.heat_term.law import HeatLaw
from warmlink.fmus.names import listed
from warmlink.orchestration.machine import DEFAULT
from warmlink.orchestration.machine.rig import rig
from warmlink.orchestration.machine.terms import PLACES, placed_term

FOLLOWED = (
    *("speed", "torque", "ambient_temperature", "shaft_temperature", "winding_temperature"),
    *("base_temperature", "middle_temperature", "tip_temperature"),
)
"""Names that the law of a hidden term may have beside its parameters and the time."""


MOST_HEAT = 1e6
"""W that a hidden term may give: more is a slip, and no solver follows it."""


@dataclass(frozen=True)
class HiddenTerm:
    """Heat in W into a place of the true cell: `shaft`, `winding`, `base` or `tip`."""

    into: str
    law: HeatLaw
    parameters: Mapping[str, float]

    def heat(self, values: Mapping[str, float], lagged: Sequence[float], time: float) -> float:
        """Heat in W at values of the cell's variables in SI, of the law's lags, and a time in s."""
        fault, heat = "", math.nan
        try:
            heat = float(self.law.heat(self._of(values), lagged, time))
        except ArithmeticError as error:
            fault = f" ({error})"
        if not abs(heat) < MOST_HEAT:
            raise InputError(
                f"term {self.law.text!r}: is no heat below {MOST_HEAT:g} W at {time:g} s{fault}; give "
                "a weaker one, in which nothing is divided by 0"
            )
        return heat

    def lag_rates(self, values: Mapping[str, float], lagged: Sequence[float], time: float) -> Sequence[float]:
        """Time derivatives of the law's lags."""
        return self.law.lag_rates(self._of(values), lagged, time)

    def _of(self, values: Mapping[str, float]) -> Callable[[str], float]:
        return lambda name: self.parameters[name] if name in self.parameters else values[name]


def hidden_term(text: str) -> HiddenTerm:
    """Read a term as `PLACE: EXPRESSION; NAME = VALUE; NAME = VALUE`; raises InputError if it is none."""
    into, colon, rest = text.partition(":")
    into, (heat, *given) = into.strip(), [part.strip() for part in rest.split(";")]
    if not colon or into not in PLACES or not heat:
        raise InputError(
            f'term {text!r}: is no place and heat; write "shaft: a * max(speed - b, 0)**1.5; a = 0.3; '
            f'b = 0.5 rad/s", with one of {listed(PLACES, "or")} before the colon'
        )
    parameters: dict[str, str | float] = {}
    for each in filter(None, given):
        name, equals, value = (part.strip() for part in each.partition("="))
        if not equals or not name.isidentifier():
            raise InputError(f"term {text!r}: {each!r} is no value of a parameter; write a = 0.3 W")
        parameters[name] = value
    placed = placed_term(rig(DEFAULT), "hidden", heat, into, parameters, f"term {text!r}")
    for name in placed.variables:
        if name not in FOLLOWED:
            raise InputError(
                f"term {text!r}: a made-up run has no {name}; use {listed(FOLLOWED, 'or')}, or the time"
            )
    values = {name: value for name, (value, _) in placed.term.parameters.items()}
    return HiddenTerm(into, HeatLaw(heat), values)

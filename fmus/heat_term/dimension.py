"""What a law is of: its unit from those of its variables, so that a heat that is none is refused.

A number without a unit is in SI and takes whatever unit is due; rad is a plain number, as in N.m rad/s = W.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from warmlink.fmus.component.units import BASE_UNITS, unit
from warmlink.fmus.errors import InputError
from warmlink.fmus.heat_term.law import FUNCTIONS, LAG, TIME, HeatLaw

_COUNTED = tuple(base for base in BASE_UNITS if base != "rad")


class NotAlikeError(ValueError):
    """Two quantities of different dimension are added, compared or chosen from."""


@dataclass(frozen=True)
class Dimension:
    """Powers of the base units, rad aside; None for what takes any unit. A constant also has its `value`."""

    powers: tuple[Fraction, ...] | None = None
    value: float | None = None

    @classmethod
    def of(cls, text: str) -> Dimension:
        """Dimension of a unit in Modelica's notation."""
        exponents = unit(text).exponents
        return cls(tuple(Fraction(exponents.get(base, 0)) for base in _COUNTED))

    def __add__(self, other: Dimension) -> Dimension:
        if self.powers is None or other.powers is None:
            return Dimension(self.powers or other.powers)
        if self.powers != other.powers:
            raise NotAlikeError(f"{self} and {other}")
        return Dimension(self.powers)

    __sub__ = __add__

    def __mul__(self, other: Dimension) -> Dimension:
        return self._with(other, 1)

    def __truediv__(self, other: Dimension) -> Dimension:
        return self._with(other, -1)

    def __neg__(self) -> Dimension:
        return Dimension(self.powers, None if self.value is None else -self.value)

    def __pos__(self) -> Dimension:
        return self

    def _with(self, other: Dimension, sign: int) -> Dimension:
        if self.powers is None or other.powers is None:
            return Dimension()
        return Dimension(tuple(a + sign * b for a, b in zip(self.powers, other.powers, strict=True)))

    def to_the(self, exponent: Dimension) -> Dimension:
        """Power of it; only a constant may be the exponent of what has a unit."""
        if self.powers is None or not any(self.powers):
            return self if self.powers is not None else Dimension()
        if exponent.value is None:
            raise NotAlikeError(f"{self} to a power that is no number; divide it by a value of its own unit")
        return Dimension(
            tuple(each * Fraction(exponent.value).limit_denominator(1000) for each in self.powers)
        )

    def __str__(self) -> str:
        if self.powers is None:
            return "any unit"
        parts = [
            base if power == 1 else f"{base}{power}" if power.denominator == 1 else f"{base}^({power})"
            for base, power in zip(_COUNTED, self.powers, strict=True)
            if power
        ]
        return ".".join(parts) or "a plain number"


_PLAIN = Dimension((Fraction(0),) * len(_COUNTED))


def _plain(given: Dimension) -> Dimension:
    return given + _PLAIN


_RULES: Mapping[str, Callable[..., Dimension]] = {
    "abs": lambda given: Dimension(given.powers),
    "sqrt": lambda given: given.to_the(Dimension(_PLAIN.powers, 0.5)),
    "exp": _plain,
    "max": Dimension.__add__,
    "min": Dimension.__add__,
    "sign": lambda given: _PLAIN,
    "step": lambda given: _PLAIN,
}


def _lagged(follows: Dimension, constant: Dimension) -> Dimension:
    if constant.powers is not None and constant.powers != Dimension.of("s").powers:
        raise NotAlikeError(f"the time constant of a lag is in {constant}, not in s")
    return Dimension(follows.powers)


def refuse_other_than_heat(law: HeatLaw, units: Mapping[str, str | None]) -> None:
    """Raise InputError if a law is of another unit than W.

    Parameters
    ----------
    law : the expression
    units : unit of each of its names in Modelica's notation; None for a number without a unit
    """
    known = {name: Dimension() if text is None else Dimension.of(text) for name, text in units.items()}
    known[TIME] = Dimension.of("s")
    rules = {name: (count, _RULES[name]) for name, (count, _) in FUNCTIONS.items()} | {LAG: (2, _lagged)}
    try:
        found = law.in_arithmetic(
            known.__getitem__, rules, Dimension.to_the, lambda value: Dimension(None, value)
        )
    except NotAlikeError as fault:
        raise InputError(f"{law.where}: {law.text!r} mixes units: {fault}") from None
    if found.powers not in (None, Dimension.of("W").powers):
        raise InputError(
            f"{law.where}: {law.text!r} is in {found}, and heat is in W; mend the units of its parameters"
        )

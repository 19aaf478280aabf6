"""Units in Modelica's notation: their base units, and the units in which people read values.

`W/(m2.K)` is a product of unit symbols with exponents, at most one division, the divisor in brackets
where it has several factors (Modelica specification 3.6, section 19.1).
"""

import math
import re
from dataclasses import dataclass, field
from fractions import Fraction

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""Base units in which FMI states exponents, in its order."""


@dataclass(frozen=True)
class ComponentUnit:
    """A unit as a product of base units.

    `value in base units = factor * value + offset`; exponents of zero are left out.
    """

    exponents: dict[str, int] = field(default_factory=dict)
    factor: Fraction = Fraction(1)
    offset: Fraction = Fraction(0)


def _si(factor: str = "1", **exponents: int) -> ComponentUnit:
    return ComponentUnit(exponents, Fraction(factor))


_SYMBOLS = {
    **{symbol: ComponentUnit({symbol: 1}) for symbol in BASE_UNITS},
    "1": _si(),
    "N": _si(kg=1, m=1, s=-2),
    "Pa": _si(kg=1, m=-1, s=-2),
    "J": _si(kg=1, m=2, s=-2),
    "W": _si(kg=1, m=2, s=-3),
    "V": _si(kg=1, m=2, s=-3, A=-1),
    "Ohm": _si(kg=1, m=2, s=-3, A=-2),
    "Hz": _si(s=-1),
    "g": _si("1e-3", kg=1),
    "cm": _si("1e-2", m=1),
    "mm": _si("1e-3", m=1),
    "um": _si("1e-6", m=1),
    "µm": _si("1e-6", m=1),
    "nm": _si("1e-9", m=1),
    "ms": _si("1e-3", s=1),
    "min": _si("60", s=1),
    "h": _si("3600", s=1),
    "mW": _si("1e-3", kg=1, m=2, s=-3),
    "kW": _si("1e3", kg=1, m=2, s=-3),
    "kJ": _si("1e3", kg=1, m=2, s=-2),
    "deg": ComponentUnit({"rad": 1}, Fraction(math.pi / 180)),
    "rpm": ComponentUnit({"rad": 1, "s": -1}, Fraction(math.pi / 30)),
    "%": _si("1e-2"),
    "degC": ComponentUnit({"K": 1}, offset=Fraction("273.15")),
    "°C": ComponentUnit({"K": 1}, offset=Fraction("273.15")),
    "degF": ComponentUnit({"K": 1}, Fraction(5, 9), Fraction("273.15") - Fraction(160, 9)),
}

_QUOTIENT = re.compile(r"([^/()]+)(?:/(?:\(([^/()]+)\)|([^/().]+)))?")
"""A product, and by what it is divided: a product in brackets, or one factor."""


def unit(text: str) -> ComponentUnit:
    """Unit that a text in Modelica's notation means.

    ValueError: a symbol is not known, or the text is not of this form.
    """
    if text in _SYMBOLS:
        return _SYMBOLS[text]
    parts = _QUOTIENT.fullmatch(text)
    if parts is None:
        raise ValueError(f"unit {text!r} is not in Modelica's notation, as 'W/(m2.K)'")
    dividend, several, one = (part.split(".") if part else [] for part in parts.groups())
    factors = [*((factor, 1) for factor in dividend), *((factor, -1) for factor in (*several, *one))]
    exponents = dict.fromkeys(BASE_UNITS, 0)
    scale = Fraction(1)
    for factor, sign in factors:
        match = re.fullmatch(r"(1$|[A-Za-zµ%]+)(-?[1-9][0-9]?)?", factor)
        if match is None or match[1] not in _SYMBOLS or _SYMBOLS[match[1]].offset:
            raise ValueError(f"unit {text!r}: {factor!r} is not known; write it as in 'W/(m2.K)'")
        symbol, power = _SYMBOLS[match[1]], sign * int(match[2] or 1)
        scale *= symbol.factor**power
        for base, exponent in symbol.exponents.items():
            exponents[base] += exponent * power
    return ComponentUnit({base: exponent for base, exponent in exponents.items() if exponent}, scale)


def display_conversion(text: str, display: str) -> tuple[float, float]:
    """Factor and offset by which `displayed value = factor * value + offset`.

    ValueError: the value's unit and the unit in which it is read measure different things.
    """
    stored, shown = unit(text), unit(display)
    if stored.exponents != shown.exponents:
        raise ValueError(f"unit {text!r} cannot be displayed in {display!r}")
    return float(stored.factor / shown.factor), float((stored.offset - shown.offset) / shown.factor)

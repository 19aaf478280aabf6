"""The library of terms: forms of heat in W, each with a strength `a` in W and numbers of its shape.

A form divides what it follows by a value of the same unit (`w`, `m`, `k`), so that every power of it is a
plain number. Where it enters is free, but for what only one place can know.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np

from warmlink.fmus.heat_term.law import HeatLaw
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.terms.shape import ShapeNumber

UNITS: Mapping[str, tuple[float, str]] = {
    "w": (1.0, "rad/s"),
    "m": (1.0, "N.m"),
    "k": (10.0, "K"),
    "c": (300.0, "K"),
}
"""What forms divide by: value and unit by name."""

MORE: Mapping[str, tuple[float, str]] = {"h": (3600.0, "s"), "s": (0.05, "rad/s")}
"""Further fixed values of forms: an hour, and a speed that counts as none."""

_EVERYWHERE = ("shaft", "winding", "base", "tip")
_OWN = "own_temperature"
"""Stands in a form for the temperature of the place that the heat enters."""


@dataclass(frozen=True)
class Form:
    """A form of heat.

    Attributes
    ----------
    about : what it is, in a few words
    heat : its law, with a strength `a` in W
    places : where it may enter
    shapes : numbers of its shape
    causes : cause of the catalogue that it is by another name, by place
    """

    about: str
    heat: str
    places: tuple[str, ...] = _EVERYWHERE
    shapes: tuple[ShapeNumber, ...] = ()
    causes: Mapping[str, str] = field(default_factory=dict, hash=False)

    def at(self, place: str) -> Form:
        """The form where the heat enters a place."""
        return replace(self, heat=self.heat.replace(_OWN, f"{place}_temperature"))

    @cached_property
    def law(self) -> HeatLaw:
        """Its heat as an expression."""
        return HeatLaw(self.heat)

    @property
    def variables(self) -> tuple[str, ...]:
        """Variables of the machine in it."""
        known = {"a", *UNITS, *MORE, *(each.name for each in self.shapes)}
        return tuple(name for name in self.law.variables if name not in known)


_SPEED, _TORQUE = "speed", "torque"
_DEAD = ShapeNumber("b", "rad/s", of=_SPEED)
_SWITCH = ShapeNumber("b", "rad/s", of=_SPEED, fitted=False)
_MEMORY = ShapeNumber("tau", "s", values=tuple(np.geomspace(100.0, 5000.0, 9).tolist()))
_SHORT = ShapeNumber("tau", "s", values=tuple(np.geomspace(40.0, 1200.0, 7).tolist()))

_SECOND = ShapeNumber("b", "K", values=(250.0, 270.0, 280.0, 287.0, 293.0, 300.0, 310.0, 325.0, 350.0))


def _powers(
    signal: str, unit: str, places: tuple[str, ...], known: Mapping[float, Mapping[str, str]]
) -> list[Form]:
    """Powers of a signal."""
    return [
        Form(
            f"{signal} to the power {power:g}" if power != 1 else f"proportional to {signal}",
            f"a * ({signal} / {unit})**{power:g}" if power != 1 else f"a * {signal} / {unit}",
            places,
            causes=known.get(power, {}),
        )
        for power in (0.5, 1.0, 1.5, 2.0, 3.0)
    ]


_COULOMB = {"shaft": "coulomb_friction"}
_SPEEDS: dict[float, dict[str, str]] = {
    1.0: _COULOMB,
    2.0: {"shaft": "viscous_friction", "winding": "iron_loss"},
}

FORMS: tuple[Form, ...] = (
    Form("constant", "a", causes={"shaft": "standby_heat"}),
    Form("growing with time", "a * time / h"),
    *_powers(_SPEED, "w", _EVERYWHERE, _SPEEDS),
    *_powers(_TORQUE, "m", ("shaft", "winding", "base"), {2.0: {"winding": "copper_loss"}}),
    Form("proportional to mechanical power", "a * speed / w * torque / m"),
    Form("speed times squared torque", "a * speed / w * (torque / m)**2", ("shaft", "winding")),
    Form("squared speed times torque", "a * (speed / w)**2 * torque / m", ("shaft", "winding")),
    *(
        Form(f"{name} above a dead zone", f"a * (max(speed - b, 0) / w){power}", shapes=(_DEAD,))
        for name, power in (("speed", ""), ("speed to the power 1.5", "**1.5"), ("squared speed", "**2"))
    ),
    Form(
        "torque above a dead zone",
        "a * max(torque - b, 0) / m",
        ("shaft", "winding", "base"),
        (ShapeNumber("b", "N.m", of=_TORQUE),),
    ),
    Form("speed up to saturation", "a * min(speed / b, 1)", shapes=(_DEAD,)),
    Form("only above a speed", "a * step(speed - b)", shapes=(_SWITCH,)),
    Form("speed, below a speed alone", "a * speed / w * step(b - speed)", shapes=(_SWITCH,)),
    Form("stick at low speed", "a * speed / w * exp(-speed / b)", shapes=(_DEAD,)),
    Form(
        "only above a torque",
        "a * step(torque - b)",
        shapes=(ShapeNumber("b", "N.m", of=_TORQUE, fitted=False),),
    ),
    Form(
        "switched on by cold surroundings",
        "a * step(b - ambient_temperature)",
        shapes=(ShapeNumber("b", "K", of="ambient_temperature", fitted=False),),
    ),
    Form(
        "switched off by its own temperature",
        "a * step(b - own_temperature)",
        shapes=(ShapeNumber("b", "K", of=_OWN, fitted=False),),
    ),
    Form(
        "proportional to a rise above ambient",
        "a * (own_temperature - ambient_temperature) / k",
        causes={"shaft": "housing_heat_loss", "base": "hub_heat_loss", "tip": "tip_heat_loss"},
    ),
    Form(
        "a rise above ambient, beyond a dead zone",
        "a * max(own_temperature - ambient_temperature - b, 0) / k",
        shapes=(ShapeNumber("b", "K", values=(1.0, 2.0, 3.5, 5.0, 7.0, 10.0, 14.0, 20.0)),),
    ),
    Form("speed times a rise above ambient", "a * speed / w * (own_temperature - ambient_temperature) / k"),
    Form(
        "radiation to the surroundings",
        "a * ((own_temperature / c)**4 - (ambient_temperature / c)**4)",
    ),
    Form(
        "radiation to second surroundings",
        "a * ((own_temperature / c)**4 - (b / c)**4)",
        shapes=(_SECOND,),
    ),
    Form(
        "conduction to second surroundings",
        "a * (own_temperature - b) / k",
        shapes=(_SECOND,),
    ),
    Form(
        "friction of a seal that is tight when cold",
        "a * speed / w * max(b - shaft_temperature, 0) / k",
        ("shaft",),
        (ShapeNumber("b", "K", of="shaft_temperature"),),
    ),
    Form(
        "friction of a seal that is tight when warm",
        "a * speed / w * max(shaft_temperature - b, 0) / k",
        ("shaft",),
        (ShapeNumber("b", "K", of="shaft_temperature"),),
    ),
    Form(
        "friction that falls with warmth",
        "a * speed / w * (shaft_temperature - c) / k",
        ("shaft",),
        causes={"shaft": "friction_temperature_dependence"},
    ),
    Form("memory of speed", "a * lag(speed / w, tau)", shapes=(_MEMORY,)),
    Form("memory of torque", "a * lag(torque / m, tau)", ("shaft", "winding", "base"), (_MEMORY,)),
    Form(
        "friction that runs in",
        "a * speed / w * (1 - lag(step(speed - s), tau))",
        ("shaft",),
        (_MEMORY,),
    ),
    Form("change of speed", "a * abs(speed - lag(speed, tau)) / w", shapes=(_SHORT,)),
    Form("change of torque", "a * abs(torque - lag(torque, tau)) / m", ("shaft", "winding"), (_SHORT,)),
)
"""Every form."""


@dataclass(frozen=True)
class Candidate:
    """A form at a place, with values of its shape's numbers in SI."""

    form: Form
    place: str
    shape: tuple[float, ...]

    @property
    def key(self) -> tuple[str, str]:
        """Form and place, whatever the numbers."""
        return self.form.about, self.place

    @property
    def cause(self) -> str:
        """Cause of the catalogue that it is by another name; empty if it is none."""
        return self.form.causes.get(self.place, "")

    @property
    def fixed(self) -> dict[str, tuple[float, str]]:
        """Value and unit of what is not fitted."""
        names = self.form.law.variables
        known = {**UNITS, **MORE}
        switches = zip(self.form.shapes, self.shape, strict=True)
        return {
            **{name: known[name] for name in names if name in known},
            **{each.name: (value, each.unit) for each, value in switches if not each.fitted},
        }

    @property
    def numbers(self) -> int:
        """Numbers that it takes, its strength included."""
        return 1 + len(self.shape)


def candidates(signals: Mapping[str, Array], places: tuple[str, ...]) -> Iterator[Candidate]:
    """Every candidate that a machine's signals allow.

    Parameters
    ----------
    signals : values in SI of each variable over all fitted rows, shape (rows,)
    places : where heat may enter
    """
    for form in FORMS:
        for place in (each for each in places if each in form.places):
            here = form.at(place)
            if any(name not in signals for name in here.variables):
                continue
            own = [replace(s, of=s.of.replace(_OWN, f"{place}_temperature")) for s in here.shapes]
            shapes = [each.seen(signals) for each in own]
            for values in product(*(each.tried(signals) for each in shapes)):
                yield Candidate(replace(here, shapes=tuple(shapes)), place, tuple(map(float, values)))

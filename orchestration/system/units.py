"""Units as FMI and SSP define them, and the linear conversion between two of them.

A unit is its exponents of the SI base units and rad, a factor and an offset: `base = factor * value +
offset` (FMI 2.0 section 2.2.2, SSP 1.0 section 4.1). Where a file names a unit without defining it, the
name itself is read, in Modelica's notation or any that pint knows.
"""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from warmlink.fmus.component.units import BASE_UNITS
from warmlink.fmus.component.units import unit as modelica_unit
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.cache import remembered
from warmlink.orchestration.system import xml
from warmlink.orchestration.text_files import shortened

ZERO_CELSIUS = 273.15
"""0 degC in K."""

# Names that others write and pint spells otherwise. pint counts a radian as a plain number; FMI does not,
# hence units of its own for plane angles.
_SPELLINGS = {
    "Ohm": "ohm",
    "degree_C": "degC",
    "mrad": "mplane_rad",
    "urad": "uplane_rad",
    "µrad": "uplane_rad",
    **{angle: f"plane_{angle}" for angle in ("rad", "deg", "rev", "rpm")},
    **{f"{word}{s}": f"plane_{word[:3]}" for word in ("radian", "degree", "revolution") for s in ("", "s")},
}
_MEANT = {
    "degC": "C|ºC|℃|Â°C|Celsius|Deg C|deg C|degree C|degrees C|° C",
    "degF": "F",
    "N.m": "Nm|NM",
    "mN.m": "mNm",
    "rpm": "1/min|U/min|r/min",
    "rad/s": "rad_s|rad_per_s|rads",
    "s": "S|Sec|seconds|hh:mm:ss",
}
SPELLINGS = {spelling: unit for unit, each in _MEANT.items() for spelling in each.split("|")}
"""Spellings that would mean something else, or nothing, where a unit of this quantity is due."""
_PLANE_ANGLES = (
    "plane_rad = [angle]",
    "plane_deg = 0.017453292519943295 * plane_rad",
    "plane_rev = 6.283185307179586 * plane_rad",
    "plane_rpm = plane_rev / minute",
)
_SPELLED = re.compile(rf"\b({'|'.join(_SPELLINGS)})\b")
_WORD = re.compile(r"[^\W\d_]+")
_DOT = re.compile(r"(?<=[\w)])\s*[.·⋅]\s*(?=[^\W\d]|\(|1/)")
_POWER = re.compile(r"(?<![\w.])([^\W\d]+)\^?(-?\d{1,2})(?![\w.])")
# Names, the number 1, products, quotients, brackets and whole powers of one or two digits. pint would work
# out anything else that looks like arithmetic, 9**9**9 too. A name is taken whole: tried in every way in
# which it falls into shorter ones, thirty letters would take minutes.
_WRITTEN = re.compile(
    r"(?:\s*+(?:[^\W\d]\w*+|°\w++|1(?!\d)|/|\(|\)|\*(?!\*)|\*\*\s*(?:\(-?\d{1,2}\)|-?\d{1,2}(?!\d))(?!\s*\*\*)))*\s*"
)
_SPACES, _SPACES_AROUND = re.compile(r"\s+"), re.compile(r"\s*([*./()])\s*")
_PLAIN_NUMBER = ("", "1", "-")
_IN_BRACKETS = re.compile(r"\s*\[([^][]*)\]\s*")
_LONGEST_NAME = 80
# pint's names for the dimensions of BASE_UNITS.
_DIMENSIONS = tuple(
    f"[{each}]"
    for each in ("mass", "length", "time", "current", "temperature", "substance", "luminosity", "angle")
)


class QuantityError(InputError):
    """Two units measure different quantities: `W does not convert to K`."""


@dataclass(frozen=True)
class Unit:
    """A unit with its name in the file, as `W/(m2.K)`: `base = factor * value + offset`.

    The exponents are of kg, m, s, A, K, mol, cd, rad; None where a file only names it.
    """

    name: str
    exponents: tuple[int, ...] | None = None
    factor: float = 1.0
    offset: float = 0.0

    @property
    def dash(self) -> bool:
        """Whether it is an undefined "-", which some write for a number and others for no unit."""
        return self.exponents is None and self.name.strip() == "-"


@dataclass(frozen=True)
class Conversion:
    """`target = factor * source + offset`."""

    factor: float = 1.0
    offset: float = 0.0

    def __call__(self, value: float) -> float:
        """Convert one value."""
        return self.factor * value + self.offset

    def then(self, factor: float, offset: float) -> Conversion:
        """Give this conversion followed by another linear transformation."""
        return Conversion(factor * self.factor, factor * self.offset + offset)

    @property
    def identity(self) -> bool:
        """Whether it changes nothing."""
        return self.factor == 1.0 and self.offset == 0.0


IDENTITY = Conversion()


def conversion(source: Unit, target: Unit, difference: bool = False) -> Conversion:
    """Give the conversion between two units of one quantity; where one has no exponents its name is read.

    Offsets do not apply to a `difference`: 5 degC of difference are 5 K. QuantityError if the units measure
    different quantities (the caller adds where, and what to do), InputError if one is not known.
    """
    if source.name == target.name and (source.exponents is None or target.exponents is None):
        return IDENTITY
    source, target = meaning(source), meaning(target)
    if source.exponents != target.exponents:
        names = (shortened(each.name or "1") for each in (source, target))
        raise QuantityError(" does not convert to ".join(names))
    if (source.factor, source.offset) == (target.factor, target.offset):
        return IDENTITY
    factor = source.factor / target.factor
    return Conversion(factor, 0.0 if difference else (source.offset - target.offset) / target.factor)


def spelled(given: str, unit: str) -> str:
    """How warmlink spells a unit that people write otherwise, where a unit like the second one is due."""
    meant = SPELLINGS.get(given, given)
    words = _WORD.sub(lambda word: f"({SPELLINGS[word[0]]})" if word[0] in SPELLINGS else word[0], given)
    for each in (given, meant, words):
        with contextlib.suppress(InputError):
            conversion(parse_unit(each), parse_unit(unit))
            return each
    return meant


def meaning(unit: Unit) -> Unit:
    """Give the unit with its exponents, read from its name where the file defined none."""
    return parse_unit(unit.name) if unit.exponents is None else unit


def read_unit(element: Any, where: str) -> Unit:
    """Give the unit that a `Unit` element of FMI or SSP defines."""
    name = xml.required(element, "name", where)
    base = element.find("{*}BaseUnit")
    if base is None:
        return Unit(name)
    where = f"{where}: unit {name}"
    exponents = tuple(xml.optional(base, key, xml.integer, where) or 0 for key in BASE_UNITS)
    factor = xml.optional(base, "factor", xml.number, where)
    if factor == 0:
        raise InputError(f"{where}: its factor is 0, which converts nothing; give the factor to SI units")
    offset = xml.optional(base, "offset", xml.number, where) or 0.0
    return Unit(name, exponents, 1.0 if factor is None else factor, offset)


def definitions_of_units(root: Any, where: str, holder: str = "Units") -> dict[str, Unit]:
    """Give the units, by name, that the elements `Unit` in the holder of a document of FMI or SSP define."""
    found = (read_unit(each, where) for each in root.iterfind(f"{{*}}{holder}/{{*}}Unit"))
    return {unit.name: unit for unit in found}


def named_unit(name: str | None, known: dict[str, Unit], where: str, remarks: list[str]) -> Unit | None:
    """Give the unit of a value or connector, which a document defines or only names; None if it has none.

    A name in brackets, as `[m]`, joins the document's `known` units, so that it is remarked upon once.
    """
    if not name:
        return None
    bare = _IN_BRACKETS.fullmatch(name)
    if name not in known and bare:
        inside = bare[1].strip() or "1"
        known[name] = known.get(inside, Unit(inside))
        remarks.append(f"{where}: the unit {name} is read as {inside} throughout")
    return known.get(name, Unit(name))


@lru_cache(maxsize=512)
def parse_unit(name: str) -> Unit:
    """Read a unit's name: `W/(m2.K)`, `N.m`, `rad/s`, `W.s2/rad2`, `degC`, `um`, `W/(m**2*K)`, `1`.

    A radian counts as a base unit, as it does in FMI. InputError if the name is no unit.
    """
    if len(name) > _LONGEST_NAME:
        raise InputError(f"{name[:40]!r}... is not a unit; define it with a BaseUnit")
    text = _POWER.sub(r"\1**(\2)", _DOT.sub("*", name.strip()))
    text = _SPELLED.sub(lambda found: _SPELLINGS[found.group(1)], text).replace("%", "percent")
    if text in _PLAIN_NUMBER:
        return Unit(name, (0,) * len(BASE_UNITS))
    if not _WRITTEN.fullmatch(text):
        raise InputError(f"{name!r} is not a unit; define it with a BaseUnit, or write it as in W/(m2.K)")
    with contextlib.suppress(
        ValueError, OverflowError
    ):  # one of those that components are declared in needs no pint
        tight = _SPACES_AROUND.sub(r"\1", name.strip())  # a space that is left stands for a product
        known = modelica_unit(_SPACES.sub(".", tight.replace("**", "").replace("*", ".")))
        exponents = tuple(known.exponents.get(base, 0) for base in BASE_UNITS)
        return Unit(name, exponents, float(known.factor), float(known.offset))
    # To import pint and to read its tables takes as long as a short run.
    return remembered("units", (name, text), lambda: _from_pint(name, text))


def _from_pint(name: str, text: str) -> Unit:
    registry = _registry()
    try:
        units = registry.Unit(text)
        zero = registry.Quantity(0.0, units).to_base_units()
        # A scale that starts elsewhere is a bare temperature, whose differences pint knows under this name.
        step = units if zero.magnitude == 0 else f"delta_{text}"
        factor = float(registry.Quantity(1.0, step).to_base_units().magnitude)
    except Exception as fault:  # its parser raises many kinds, pint's own and syntax errors among them
        raise InputError(
            f"{name!r} is not a known unit; define it with a BaseUnit, or write it as in W/(m2.K)"
        ) from fault
    powers = zero.dimensionality
    if not all(each in _DIMENSIONS and int(n) == n and abs(n) <= 20 for each, n in powers.items()):
        raise InputError(f"{name!r} is not a unit of SI base units and rad with whole exponents")
    if not math.isfinite(factor) or factor == 0:
        raise InputError(f"{name!r} is not a unit of finite size")
    exponents = tuple(int(powers.get(each, 0)) for each in _DIMENSIONS)
    return Unit(name, exponents, factor, float(zero.magnitude))


@lru_cache(maxsize=1)
def _registry() -> Any:
    """Give pint's registry with kilogram as base unit, and plane angles with a dimension of their own."""
    import pint

    registry: Any = pint.UnitRegistry(system="mks", autoconvert_offset_to_baseunit=True)
    for definition in _PLANE_ANGLES:
        registry.define(definition)
    return registry


def unit_elements(root: Any, prefix: str, units: Iterable[Unit]) -> None:
    """Add a `Units` element with the definitions of some units, by name; nothing where there are none."""
    ordered = sorted(units, key=lambda unit: unit.name)
    held = xml.sub_element(root, prefix, "Units") if ordered else None
    for unit in map(meaning, ordered):
        shown = dict(zip(BASE_UNITS, (each or None for each in unit.exponents or ()), strict=True))
        scale = None if unit.factor == 1.0 else unit.factor
        child = xml.sub_element(held, "ssc", "Unit", name=unit.name)
        xml.sub_element(child, "ssc", "BaseUnit", **shown, factor=scale, offset=unit.offset or None)

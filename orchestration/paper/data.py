"""The paper's materials, geometry and printed numbers, read from the two TOML files beside this module.

[1] P. Poonyapak, M.J.D. Hayes, J.M.J. McDill, "Temperature-Induced Deformation in a Mechanical System".
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError

_HERE = Path(__file__).parent


@dataclass(frozen=True)
class Material:
    """Properties of one material, constant over 20 to 100 degC ([1] V.A), SI units.

    `conductivity` [W/(m.K)], `density` [kg/m3], `specific_heat` [J/(kg.K)], `youngs_modulus` [Pa],
    `poissons_ratio` [1], `expansion_coefficient` [1/K], `emissivity` [1].
    """

    name: str
    source: str
    conductivity: float
    density: float
    specific_heat: float
    youngs_modulus: float
    poissons_ratio: float
    expansion_coefficient: float
    emissivity: float

    @property
    def diffusivity(self) -> float:
        """Thermal diffusivity k / (rho c) [m2/s], [1] IV."""
        return self.conductivity / (self.density * self.specific_heat)


@dataclass(frozen=True)
class Materials:
    """The three materials of the paper's assembly."""

    link: Material
    shaft: Material
    diode: Material


@dataclass(frozen=True)
class Geometry:
    """Sizes of link, shaft and laser diode [m]; `assumed` names those the paper does not give."""

    source: str
    length: float
    width: float
    thickness: float
    shaft_centre: float
    diode_centre: float
    shaft_diameter: float
    shaft_bore: float
    shaft_length: float
    diode_diameter: float
    diode_length: float
    assumed: tuple[str, ...] = ()

    @property
    def span(self) -> float:
        """Distance from the shaft's centre to the diode's centre [m]."""
        return self.diode_centre - self.shaft_centre


@dataclass(frozen=True)
class Printed:
    """A number as printed in [1], with its unit and the place where it stands."""

    value: float
    unit: str
    place: str


@cache
def load_materials(path: Path = _HERE / "materials.toml") -> Materials:
    """Read the material table.

    Raises
    ------
    InputError
        A section or a property is missing, or a property is not positive.
    """
    tables = _read(path)
    return Materials(**{f.name: _material(tables, f.name, path) for f in fields(Materials)})


@cache
def load_geometry(path: Path = _HERE / "materials.toml") -> Geometry:
    """Read the `[geometry]` section.

    Raises
    ------
    InputError
        A length is missing or not positive.
    """
    table = _section(_read(path), "geometry", path)
    lengths = [f.name for f in fields(Geometry) if f.name not in ("source", "assumed")]
    numbers = {name: _positive(table, name, "geometry", path) for name in lengths}
    return Geometry(source=str(table["source"]), assumed=tuple(table["assumed"]), **numbers)


@cache
def load_paper(path: Path = _HERE / "paper.toml") -> dict[str, dict[str, Printed]]:
    """Read every number printed in [1] as `paper[section][name]`.

    Raises
    ------
    InputError
        An entry lacks its value, unit or place.
    """
    paper: dict[str, dict[str, Printed]] = {}
    for section, table in _read(path).items():
        paper[section] = {}
        for name, entry in table.items():
            try:
                paper[section][name] = Printed(float(entry["value"]), str(entry["unit"]), str(entry["place"]))
            except (KeyError, TypeError) as error:
                raise InputError(f"{path.name}: {section}.{name} needs value, unit and place") from error
    return paper


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give a readable TOML file") from error
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML: {error}") from error


def _section(tables: dict[str, Any], name: str, path: Path) -> dict[str, Any]:
    if name not in tables:
        raise InputError(f"{path.name}: section [{name}] is missing; add it")
    return dict(tables[name])


def _positive(table: dict[str, Any], name: str, section: str, path: Path) -> float:
    if name not in table:
        raise InputError(f"{path.name}: {section}.{name} is missing; add it in SI units")
    if not table[name] > 0:
        raise InputError(
            f"{path.name}: {section}.{name}: {table[name]} is not above 0; give a positive number"
        )
    return float(table[name])


def _material(tables: dict[str, Any], name: str, path: Path) -> Material:
    table = _section(tables, name, path)
    numbers = [f.name for f in fields(Material) if f.name not in ("name", "source")]
    values = {number: _positive(table, number, name, path) for number in numbers}
    return Material(name=str(table["name"]), source=str(table["source"]), **values)

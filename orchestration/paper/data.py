"""The paper's materials, geometry and printed numbers, read from the two TOML files beside this module.

[1] P. Poonyapak, M.J.D. Hayes, J.M.J. McDill, "Temperature-Induced Deformation in a Mechanical System".
"""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from warmlink.orchestration.finite_elements.body import Material


@dataclass(frozen=True)
class Materials:
    """The three materials of the paper's assembly, constant over 20 to 100 degC ([1] V.A)."""

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
    assumed: Sequence[str]

    @property
    def span(self) -> float:
        """Distance from the shaft's centre to the diode's centre [m]."""
        return self.diode_centre - self.shaft_centre


class Printed(NamedTuple):
    """A number as printed in [1], with its unit and the place where it stands."""

    value: float
    unit: str
    place: str


@cache
def load_materials() -> Materials:
    """Read the material table."""
    tables = _read("materials.toml")
    return Materials(*(Material(**tables[name]) for name in ("link", "shaft", "diode")))


@cache
def load_geometry() -> Geometry:
    """Read the lengths."""
    return Geometry(**_read("materials.toml")["geometry"])


@cache
def load_paper() -> dict[str, dict[str, Printed]]:
    """Read every number printed in [1] as `paper[section][name]`."""
    return {
        section: {name: Printed(**entry) for name, entry in table.items()}
        for section, table in _read("paper.toml").items()
    }


def _read(name: str) -> dict[str, Any]:
    return tomllib.loads((Path(__file__).parent / name).read_text(encoding="utf-8"))

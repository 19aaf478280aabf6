"""The paper's materials, geometry and printed numbers, read from the two TOML files beside this module.

[1] P. Poonyapak, M.J.D. Hayes, J.M.J. McDill, "Temperature-Induced Deformation in a Mechanical System".
"""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from warmlink.orchestration.finite_elements.body import Material


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


_properties, _printed = (
    tomllib.loads(Path(__file__).with_name(name).read_text("utf-8"))
    for name in ("materials.toml", "paper.toml")
)
GEOMETRY = Geometry(**_properties.pop("geometry"))
MATERIALS = {name: Material(**table) for name, table in _properties.items()}
"""Of `link`, `shaft` and `diode`, constant over 20 to 100 degC ([1] V.A)."""

PAPER = {case: {name: Printed(**each) for name, each in table.items()} for case, table in _printed.items()}
"""Every number printed in [1], by section and name."""

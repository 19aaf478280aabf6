"""The arm's axes as data: lengths, sections, masses and conductances, and the parameters that follow."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.scenarios.quantity import quantity

GEOMETRY = Path(__file__).with_name("geometry.toml")

_UNITS = {each.name: each.unit for each in (*MOTOR.parameters, *LINK.parameters)} | {
    "joint_limit": "rad",
    "section": "m2",
    "perimeter": "m",
    "winding_mass": "kg",
    "shaft_mass": "kg",
    "copper": "J/(kg.K)",
    "steel": "J/(kg.K)",
}
"""Units by name in the file; parameters of MotorHeatSource stand there under their own names."""


@dataclass(frozen=True)
class Axis:
    """One axis: a motor in its joint and the link to the next joint.

    Attributes
    ----------
    name : as people call it
    joint_limit : largest angle in rad to either side
    mass : of motor and link, in kg
    motor, link : parameters of MotorHeatSource and ThermalLink in SI units that differ from nominal
    """

    name: str
    joint_limit: float
    mass: float
    motor: Mapping[str, float]
    link: Mapping[str, float]


@cache
def axes() -> tuple[Axis, ...]:
    """The arm's six axes, from the base outwards."""
    content = tomllib.loads(GEOMETRY.read_text("utf-8"))
    material, heats = _read(content["material"]), _read(content["metals"])
    return tuple(_axis(str(table.pop("name")), _read(table), material, heats) for table in content["axis"])


def axis(number: int) -> Axis:
    """Axis by its number from 1; beyond the sixth the arm begins again, as for several arms in a row."""
    return axes()[(number - 1) % len(axes())]


def _read(table: Mapping[str, Any]) -> dict[str, float]:
    return {name: quantity(value, _UNITS[name], name) for name, value in table.items()}


def _axis(
    name: str, size: Mapping[str, float], material: Mapping[str, float], heats: Mapping[str, float]
) -> Axis:
    motor = {key: value for key, value in size.items() if key in MOTOR.p.index}
    motor |= {
        "winding_heat_capacity": size["winding_mass"] * heats["copper"],
        "shaft_heat_capacity": size["shaft_mass"] * heats["steel"],
    }
    link = {
        "length": size["length"],
        "base_position": 0.0,
        "tip_position": size["length"],
        "cross_section": size["section"],
        "perimeter": size["perimeter"],
        **material,
    }
    mass = size["length"] * size["section"] * material["density"] + size["winding_mass"] + size["shaft_mass"]
    return Axis(name, size["joint_limit"], mass, motor, link)

"""The arm's axes as data: lengths, sections, masses and conductances, and the parameters that follow."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.orchestration.scenarios.quantity import positive, quantity

GEOMETRY = Path(__file__).with_name("geometry.toml")

_MOTOR_PARAMETERS = (
    "winding_conductance",
    "housing_conductance",
    "joint_conductance",
    "neighbour_conductance",
    "torque_constant",
    "iron_loss_coefficient",
    "coulomb_friction",
    "viscous_friction",
)
"""Parameters of MotorHeatSource that stand in the file under their own names."""

_MATERIAL = {
    "conductivity": "W/(m.K)",
    "density": "kg/m3",
    "specific_heat": "J/(kg.K)",
    "expansion_coefficient": "1/K",
    "convection_still": "W/(m2.K)",
    "convection_per_speed": "W.s/(m3.K)",
}

_MOTOR_UNITS = {parameter.name: parameter.unit for parameter in MOTOR.parameters}


@dataclass(frozen=True)
class Axis:
    """One axis: a motor in its joint and the link to the next joint.

    Attributes
    ----------
    name : as people call it
    joint_limit : largest angle in rad to either side
    length : from joint to joint, in m
    link_mass, winding_mass, shaft_mass : in kg
    motor, link : parameters of MotorHeatSource and ThermalLink in SI units that differ from nominal
    """

    name: str
    joint_limit: float
    length: float
    link_mass: float
    winding_mass: float
    shaft_mass: float
    motor: Mapping[str, float]
    link: Mapping[str, float]

    @property
    def mass(self) -> float:
        """Mass of motor and link in kg."""
        return self.link_mass + self.winding_mass + self.shaft_mass


@cache
def axes() -> tuple[Axis, ...]:
    """The arm's six axes, from the base outwards."""
    content = tomllib.loads(GEOMETRY.read_text("utf-8"))
    material = {
        name: quantity(content["material"][name], unit, f"material.{name}")
        for name, unit in _MATERIAL.items()
    }
    heats = {
        metal: positive(content["metals"][metal], "J/(kg.K)", f"metals.{metal}")
        for metal in content["metals"]
    }
    return tuple(_axis(table, material, heats) for table in content["axis"])


def axis(number: int) -> Axis:
    """Axis by its number from 1; beyond the sixth the arm begins again, as for several arms in a row."""
    return axes()[(number - 1) % len(axes())]


def _axis(table: Mapping[str, Any], material: Mapping[str, float], heats: Mapping[str, float]) -> Axis:
    name = str(table["name"])
    units = {"length": "m", "section": "m2", "perimeter": "m", "winding_mass": "kg", "shaft_mass": "kg"}
    size = {key: positive(table[key], unit, f"{name}.{key}") for key, unit in units.items()}
    motor = {key: quantity(table[key], _MOTOR_UNITS[key], f"{name}.{key}") for key in _MOTOR_PARAMETERS}
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
    limit = positive(table["joint_limit"], "rad", f"{name}.joint_limit")
    mass = size["length"] * size["section"] * material["density"]
    return Axis(name, limit, size["length"], mass, size["winding_mass"], size["shaft_mass"], motor, link)

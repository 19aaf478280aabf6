"""The arm as data: its name, its programs, its axes with the parameters that follow, and its joint angles."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from warmlink.fmus.arm_kinematics.component import COMPONENT as KINEMATICS
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.records import dataclass
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.scenarios.quantity import quantity

NAME = "SixAxisArm"
PROGRAMS = Path(__file__).parent / "programs"
GEOMETRY = Path(__file__).with_name("geometry.toml")

_UNITS = {each.name: each.unit for each in (*MOTOR.parameters, *LINK.parameters)}
_UNITS |= {"joint_limit": "rad", "section": "m2", "perimeter": "m"}
_UNITS |= {"winding_mass": "kg", "shaft_mass": "kg", "copper": "J/(kg.K)", "steel": "J/(kg.K)"}
"""Units by name in the file; parameters of MotorHeatSource stand there under their own names."""


@dataclass(frozen=True)
class Axis:
    """One axis as people call it: a motor in its joint and the link to the next joint, with their mass in kg.

    `joint_limit` is the largest angle in rad to either side; `motor` and `link` are parameters of
    MotorHeatSource and ThermalLink in SI units that differ from nominal.
    """

    name: str
    joint_limit: float
    mass: float
    motor: Mapping[str, float]
    link: Mapping[str, float]


def program_names() -> list[str]:
    """Names of the programs that ship, which are the arm's scenarios."""
    return sorted(path.stem for path in PROGRAMS.glob("*.toml"))


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
    winding, shaft, length = size["winding_mass"], size["shaft_mass"], size["length"]
    motor |= {
        "winding_heat_capacity": winding * heats["copper"],
        "shaft_heat_capacity": shaft * heats["steel"],
    }
    shape = {"cross_section": size["section"], "perimeter": size["perimeter"]}
    link = {"length": length, "base_position": 0.0, "tip_position": length, **shape, **material}
    mass = length * size["section"] * material["density"] + winding + shaft
    return Axis(name, size["joint_limit"], mass, motor, link)


def joint_angles(x: ArrayLike, y: ArrayLike, z: ArrayLike, pitch: float, roll: float = 0.0) -> Array:
    """Angles that bring the tool point to a place, with the tool in the arm's own vertical plane, elbow up.

    The wrist does not roll then, and waist, shoulder, elbow and wrist pitch are a turn and a planar arm of
    two links; closed form as in J. J. Craig, *Introduction to Robotics*, 3rd ed., chapter 4.

    Parameters
    ----------
    x, y, z : tool points in m from the arm's base, each of shape (n,) or a number
    pitch : angle in rad of the tool above the horizontal; -pi/2 points down
    roll : angle in rad of the tool about itself

    Returns
    -------
    numpy.ndarray
        In rad, shape (n, 6); NaN where the arm does not reach or a joint would pass its limit.
    """
    column, a, b, tool = _column_arms_and_tool()
    x, y, z = (np.atleast_1d(np.asarray(each, dtype=float)) for each in (x, y, z))
    out = np.hypot(x, y) - tool * np.cos(pitch)
    up = z - tool * np.sin(pitch) - column
    reach = np.hypot(out, up)
    with np.errstate(invalid="ignore"):
        elbow = -np.arccos((reach**2 - a**2 - b**2) / (2 * a * b))
        upper = np.arctan2(up, out) - np.arctan2(b * np.sin(elbow), a + b * np.cos(elbow))
    zero = np.zeros_like(x)
    joints = (np.arctan2(y, x), upper - np.pi / 2, elbow, zero, pitch - (upper + elbow), zero + roll)
    angles = np.column_stack(joints)
    angles = np.where(np.isfinite(angles), (angles + np.pi) % (2 * np.pi) - np.pi, np.nan)
    limits = np.array([each.joint_limit for each in axes()])
    within = np.all(np.abs(angles) <= limits + 1e-9, axis=1)
    return np.where(within[:, None], angles, np.nan)


@cache
def _column_arms_and_tool() -> tuple[float, ...]:
    """Lengths of column, upper arm, forearm and tool in m, out of the declaration of the arm's kinematics."""
    starts = {scalar.name: scalar.start or 0.0 for scalar in KINEMATICS.scalars()}
    return tuple(starts[f"link_{name}"] for name in ("offset[1]", "length[2]", "offset[4]", "offset[6]"))

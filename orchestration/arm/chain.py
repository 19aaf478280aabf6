"""The arm as a system: a motor and a link for each axis in a chain, sensors, compensators and kinematics.

A link's tip warms the next joint through that motor's neighbour port, and what the port takes is taken from
the link's tip. Instances are `axis1.motor`, `axis1.link` and so on, beside `poses` and `kinematics`.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warmlink.controllers.interface import OUTPUTS as CONTROLLER_OUTPUTS
from warmlink.fmus.arm_kinematics.component import COMPONENT as ARM_KINEMATICS
from warmlink.fmus.arm_kinematics.equations import AXES
from warmlink.fmus.component.join import Wire
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.catalogue import components
from warmlink.orchestration.machine.machine import COMPENSATOR, DUTY, Machine
from warmlink.orchestration.machine.shipped import WARMUP_CELL, machines
from warmlink.orchestration.system.model import Value
from warmlink.orchestration.system.ports import Ports
from warmlink.orchestration.written.quantities import quantity

POSES, KINEMATICS = "poses", "kinematics"

NAME = "SixAxisArm"
GEOMETRY = Path(__file__).with_name("geometry.toml")

_UNITS = {each.name: each.unit for each in (*MOTOR.parameters, *LINK.parameters)}
_UNITS |= {"joint_limit": "rad", "section": "m2", "perimeter": "m"}
_UNITS |= {"winding_mass": "kg", "shaft_mass": "kg", "copper": "J/(kg.K)", "steel": "J/(kg.K)"}
"""Units by name in the file; parameters of MotorHeatSource stand there under their own names."""


def arm_chain(count: int = AXES, compensated: bool = True) -> Machine:
    """Parts and wires of an arm of some axes, each with sensors and a compensator if it is `compensated`.

    Beyond six another arm of six stands on the tip of the one before; InputError for less than one.
    """
    if count < 1:
        raise InputError(f"axes: {count} is not positive; give an arm at least 1 axis")
    cell = WARMUP_CELL.without("camera", *(() if compensated else ("sensors", COMPENSATOR)))
    parts: dict[str, str] = {}
    wires: list[Wire] = []
    for i in range(1, count + 1):
        name, place, arm = axis_name(i), (i - 1) % AXES + 1, kinematics_of(i)
        part = cell.prefixed(name)
        parts |= part.parts
        wires += [
            *part.wires,
            (f"{POSES}.angle[{place}]", f"{arm}.angle[{place}]"),
            (f"{name}.link.elongation", f"{arm}.elongation[{place}]"),
        ]
        if compensated:
            wires.append((f"{name}.{COMPENSATOR}.correction", f"{arm}.correction[{place}]"))
        if i > 1:
            # Heat from a link's tip to the next joint, and back what left it.
            tip, joint = f"{axis_name(i - 1)}.link", f"{name}.motor"
            wires.append((f"{tip}.tip_temperature", f"{joint}.neighbour_temperature"))
            wires.append((f"{joint}.neighbour_heat_flow", f"{tip}.tip_heat_flow"))
    parts[POSES] = "PoseSequence"
    parts |= dict.fromkeys(map(kinematics_of, range(1, count + 1)), "ArmKinematics")
    called = NAME if count == AXES else f"Arm{count}"
    return Machine(called, machines()[NAME], parts, tuple(wires), stop_time=7200.0, ports=_ports(parts))


def axis_name(number: int) -> str:
    """Name of the inner system of an axis, numbered from 1."""
    return f"axis{number}"


def kinematics_of(number: int) -> str:
    """Instance of ArmKinematics that an axis belongs to."""
    arm = (number - 1) // AXES
    return KINEMATICS if arm == 0 else f"{KINEMATICS}{arm + 1}"


def arm_values(count: int = AXES, cut: bool = False) -> dict[str, dict[str, Value]]:
    """Start values of motors and links by instance; `cut`: no heat passes from a tip to the next joint."""
    values: dict[str, dict[str, Value]] = {}
    for i in range(1, count + 1):
        values[f"{axis_name(i)}.motor"] = dict(axis(i).motor)
        values[f"{axis_name(i)}.link"] = dict(axis(i).link)
        if cut or i == 1:
            values[f"{axis_name(i)}.motor"]["neighbour_conductance"] = 0.0
    return values


def _ports(parts: Mapping[str, str]) -> Ports:
    """Duty and angles in; errors of the tool point, elongations, corrections and readings out."""
    wanted = {
        KINEMATICS: "error",
        ".link": "elongation",
        f".{COMPENSATOR}": "correction",
        ".sensors": "reading",
    }
    shown = []
    for name, kind in parts.items():
        stem = next((each for end, each in wanted.items() if name.endswith(end)), None)
        outputs = components()[kind].outputs if kind else CONTROLLER_OUTPUTS
        names = [scalar for each in outputs if each.name == stem for scalar in each.scalar_names]
        shown += [(name, each) for each in names]
    return Ports((POSES, *(name for name in parts if name.endswith(f".{DUTY}"))), tuple(shown))


@dataclass(frozen=True)
class ArmAxis:
    """One axis as people call it: a motor in its joint and the link to the next joint, with their mass in kg.

    `joint_limit` is the largest angle in rad to either side; `motor` and `link` are parameters of
    MotorHeatSource and ThermalLink in SI units that differ from nominal.
    """

    name: str
    joint_limit: float
    mass: float
    motor: Mapping[str, float]
    link: Mapping[str, float]


@cache
def axes() -> tuple[ArmAxis, ...]:
    """The arm's six axes, from the base outwards."""
    content = tomllib.loads(GEOMETRY.read_text("utf-8"))
    material, heats = _read(content["material"]), _read(content["metals"])
    return tuple(_axis(str(table.pop("name")), _read(table), material, heats) for table in content["axis"])


def axis(number: int) -> ArmAxis:
    """Axis by its number from 1; beyond the sixth the arm begins again, as for several arms in a row."""
    return axes()[(number - 1) % len(axes())]


def _read(table: Mapping[str, Any]) -> dict[str, float]:
    return {name: quantity(value, _UNITS[name], name) for name, value in table.items()}


def _axis(
    name: str, size: Mapping[str, float], material: Mapping[str, float], heats: Mapping[str, float]
) -> ArmAxis:
    motor = {key: value for key, value in size.items() if key in MOTOR.p.index}
    winding, shaft, length = size["winding_mass"], size["shaft_mass"], size["length"]
    motor |= {
        "winding_heat_capacity": winding * heats["copper"],
        "shaft_heat_capacity": shaft * heats["steel"],
    }
    shape = {"cross_section": size["section"], "perimeter": size["perimeter"]}
    link = {"length": length, "base_position": 0.0, "tip_position": length, **shape, **material}
    mass = length * size["section"] * material["density"] + winding + shaft
    return ArmAxis(name, size["joint_limit"], mass, motor, link)


def joint_angles(x: ArrayLike, y: ArrayLike, z: ArrayLike, pitch: float, roll: float = 0.0) -> Array:
    """Angles in rad, shape (n, 6), that bring the tool point to places.

    NaN where the arm does not reach, or a joint would pass its limit; parameters as for `reaching_angles`.
    """
    angles = reaching_angles(x, y, z, pitch, roll)
    beyond = beyond_limits(angles).any(axis=1, keepdims=True)
    return np.where(beyond, np.nan, angles)


def beyond_limits(angles: Array) -> NDArray[np.bool_]:
    """Which joints pass their limits, shape (n, 6), at angles in rad, shape (n, 6)."""
    limits = np.array([each.joint_limit for each in axes()])
    return np.asarray(np.abs(angles) > limits + 1e-9)


def reaching_angles(x: ArrayLike, y: ArrayLike, z: ArrayLike, pitch: float, roll: float = 0.0) -> Array:
    """The same angles whatever the joints' limits; NaN where the arm does not reach.

    The tool stays in the arm's own vertical plane, elbow up: a turn, and a planar arm of two links, in
    closed form as in J. J. Craig, *Introduction to Robotics*, 3rd ed., chapter 4.

    Parameters
    ----------
    x, y, z : tool points in m from the arm's base, each of shape (n,) or a number
    pitch, roll : angles in rad of the tool above the horizontal (-pi/2 points down), and about itself
    """
    starts = {scalar.name: scalar.start or 0.0 for scalar in ARM_KINEMATICS.scalars()}
    names = ("offset[1]", "length[2]", "offset[4]", "offset[6]")
    column, a, b, tool = (starts[f"link_{name}"] for name in names)
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
    reached = np.isfinite(angles).all(axis=1, keepdims=True)
    return np.where(reached, (angles + np.pi) % (2 * np.pi) - np.pi, np.nan)

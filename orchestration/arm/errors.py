"""How the links' growth moves the tool point: pose by pose, in a run, and over the workspace."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from warmlink.fmus.arm_kinematics.component import COMPONENT as KINEMATICS
from warmlink.fmus.arm_kinematics.equations import AXES, COORDINATES
from warmlink.orchestration.arm.chain import POSES, axes, axis_name, joint_angles
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.machine.machine import COMPENSATOR
from warmlink.orchestration.master.recording.result import Result


def sensitivities(angles: Array) -> Array:
    """Derivative of the tool point by each elongation, shape (n, 3, 6), at angles in rad, shape (n, 6)."""
    parameters, u = KINEMATICS.start_values()
    dimensions = KINEMATICS.settled(parameters)
    poses, which = np.unique(angles, axis=0, return_inverse=True)
    found = np.empty((len(poses), len(COORDINATES), AXES))
    for k, pose in enumerate(poses):
        u[:AXES] = pose
        y = KINEMATICS.y.read(KINEMATICS.outputs_of(np.zeros(0), u, dimensions, 0.0))
        found[k] = [getattr(y, f"sensitivity_{name}") for name in COORDINATES]
    return found[which.reshape(-1)]


class ArmErrors:
    """Errors of the tool point of a run that recorded every output.

    `growth` is the true elongation of each link in m, `left` that less what is corrected, shapes (n, 6).
    """

    def __init__(self, result: Result) -> None:
        self._result = result
        self.growth = columns(result, "link.elongation")
        self.left = self.growth - columns(result, f"{COMPENSATOR}.correction")

    @cached_property
    def sensitivity(self) -> Array:
        """Derivative of the tool point by each elongation in the pose held, shape (n, 3, 6)."""
        angles = [self._result[f"{POSES}.angle[{i}]"] for i in range(1, AXES + 1)]
        return sensitivities(np.column_stack(angles))

    def tool_error(self, elongation: Array) -> Array:
        """Error of the tool point in m, x, y and z, that elongations in m make, shape (n, 3)."""
        return np.asarray(np.einsum("nki,ni->nk", self.sensitivity, elongation))

    def by_axis(self, elongation: Array) -> Array:
        """What each link adds, in m, to the error's length when that is largest, shape (6,); sums to it."""
        error = self.tool_error(elongation)
        length = np.linalg.norm(error, axis=1)
        worst = int(np.argmax(length))
        if length[worst] == 0:
            return np.zeros(AXES)
        along = error[worst] / length[worst] @ self.sensitivity[worst]
        return np.asarray(along * elongation[worst])

    def to_dict(self) -> dict[str, Any]:
        """What `metrics.json` has for the arm besides, without compensation and with it."""
        found = {}
        for name, each in (("uncompensated", self.growth), ("compensated", self.left)):
            largest = 1e6 * np.abs(self.tool_error(each)).max(axis=0)
            found[name] = {
                "max_abs_um_by_coordinate": dict(zip(COORDINATES, largest.tolist(), strict=True)),
                "largest_error_by_axis_um": by_name(1e6 * self.by_axis(each)),
                "max_abs_elongation_error_um_by_axis": by_name(1e6 * np.abs(each).max(axis=0)),
            }
        return found


def columns(result: Result, variable: str) -> Array:
    """A variable of each axis, shape (n, 6)."""
    return np.column_stack([result[f"{axis_name(i)}.{variable}"] for i in range(1, AXES + 1)])


def by_name(values: Array) -> Mapping[str, float]:
    """A value for each axis under the axes' names."""
    return {axis.name: float(value) for axis, value in zip(axes(), values, strict=True)}


@dataclass(frozen=True)
class Workspace:
    """A grid over the half-plane that the tool, pointing down, reaches; turning the waist turns the error.

    `out` and `up` are distances in m from the axis of the waist and from the base, shapes (columns,) and
    (rows,); `sensitivity` is as of `sensitivities`, NaN out of reach, shape (rows, columns, 3, 6).
    """

    out: Array
    up: Array
    sensitivity: Array

    def error(self, growth: Array) -> Array:
        """Length in m of the error that elongations in m make, shape (6,), at each point: (rows, columns)."""
        return np.asarray(np.linalg.norm(self.sensitivity @ growth, axis=-1))


def workspace(columns: int = 36, rows: int = 36) -> Workspace:
    """Grid of the workspace."""
    out, up = np.linspace(0.15, 0.9, columns), np.linspace(-0.1, 0.75, rows)
    x, z = (each.ravel() for each in np.meshgrid(out, up))
    angles = joint_angles(x, np.zeros_like(x), z, pitch=-np.pi / 2)
    reached = np.all(np.isfinite(angles), axis=1)
    found = np.full((x.size, 3, AXES), np.nan)
    found[reached] = sensitivities(angles[reached])
    return Workspace(out, up, found.reshape(rows, columns, 3, -1))

"""Where the tool point's error comes from: coordinates and axes of a run of the arm."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.arm_kinematics.equations import AXES, COORDINATES
from warmlink.orchestration.arm.blueprint import POSES, axis_name
from warmlink.orchestration.arm.geometry import axes
from warmlink.orchestration.arm.pose import sensitivities
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.system.shipped import COMPENSATOR

Array = NDArray[np.float64]


class ArmErrors:
    """Errors of the tool point of a run that recorded every output.

    Attributes
    ----------
    growth : true elongation of each link in m, shape (n, 6)
    left : the same less what its compensator corrects, shape (n, 6)
    """

    def __init__(self, result: Result) -> None:
        self._result = result
        self.growth = columns(result, "link.elongation")
        self.left = self.growth - columns(result, f"{COMPENSATOR}.correction")

    @cached_property
    def sensitivity(self) -> Array:
        """Derivative of the tool point by each elongation in the pose held, shape (n, 3, 6)."""
        return sensitivities(
            np.column_stack([self._result[f"{POSES}.angle[{i}]"] for i in range(1, AXES + 1)])
        )

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
        return {
            name: {
                "max_abs_um_by_coordinate": dict(
                    zip(COORDINATES, (1e6 * np.abs(self.tool_error(each)).max(axis=0)).tolist(), strict=True)
                ),
                "largest_error_by_axis_um": by_name(1e6 * self.by_axis(each)),
                "max_abs_elongation_error_um_by_axis": by_name(1e6 * np.abs(each).max(axis=0)),
            }
            for name, each in (("uncompensated", self.growth), ("compensated", self.left))
        }


def columns(result: Result, variable: str) -> Array:
    """A variable of each axis, shape (n, 6)."""
    return np.column_stack([result[f"{axis_name(i)}.{variable}"] for i in range(1, AXES + 1)])


def by_name(values: Array) -> Mapping[str, float]:
    """A value for each axis under the axes' names."""
    return {axis.name: float(value) for axis, value in zip(axes(), values, strict=True)}

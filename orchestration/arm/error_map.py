"""The tool point's error over the workspace, from the elongations of one moment.

Turning the waist turns the error with the arm, so that a vertical half-plane shows the whole workspace.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arm.inverse import joint_angles
from warmlink.orchestration.arm.pose import sensitivities

Array = NDArray[np.float64]

DOWN = -np.pi / 2


@dataclass(frozen=True)
class Workspace:
    """A grid over the half-plane that the tool, pointing down, reaches.

    Attributes
    ----------
    out, up : distances in m from the axis of the waist and from the base, shapes (columns,) and (rows,)
    sensitivity : derivative of the tool point by each elongation, NaN out of reach, shape
        (rows, columns, 3, 6)
    """

    out: Array
    up: Array
    sensitivity: Array

    def error(self, growth: Array) -> Array:
        """Length in m of the error that elongations in m make, shape (6,), at each point: (rows, columns)."""
        return np.asarray(np.linalg.norm(self.sensitivity @ growth, axis=-1))


def workspace(columns: int = 36, rows: int = 36, pitch: float = DOWN) -> Workspace:
    """Grid of the workspace with the tool at a pitch in rad."""
    out, up = np.linspace(0.15, 0.9, columns), np.linspace(-0.1, 0.75, rows)
    x, z = (each.ravel() for each in np.meshgrid(out, up))
    angles = joint_angles(x, np.zeros_like(x), z, pitch)
    reached = np.all(np.isfinite(angles), axis=1)
    found = np.full((x.size, 3, angles.shape[1]), np.nan)
    found[reached] = sensitivities(angles[reached])
    return Workspace(out, up, found.reshape(rows, columns, 3, -1))

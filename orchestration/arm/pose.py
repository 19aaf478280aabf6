"""How the tool point moves with the links' growth, pose by pose, from the component's own equations."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.arm_kinematics.component import COMPONENT as KINEMATICS
from warmlink.fmus.arm_kinematics.equations import AXES, COORDINATES

Array = NDArray[np.float64]


@cache
def _settled() -> Array:
    starts = [scalar.start for scalar in KINEMATICS.scalars()][: KINEMATICS.p.size]
    return np.asarray(KINEMATICS.settled(np.array(starts, dtype=float)))


def sensitivities(angles: Array) -> Array:
    """Derivative of the tool point by each elongation.

    Parameters
    ----------
    angles : joint angles in rad, shape (n, 6)

    Returns
    -------
    numpy.ndarray
        Shape (n, 3, 6), of unit columns.
    """
    poses, which = np.unique(angles, axis=0, return_inverse=True)
    found = np.empty((len(poses), len(COORDINATES), AXES))
    for k, pose in enumerate(poses):
        u = np.zeros(KINEMATICS.u.size)
        u[:AXES] = pose
        y = KINEMATICS.y.read(KINEMATICS.outputs_of(np.zeros(0), u, _settled(), 0.0))
        found[k] = [getattr(y, f"sensitivity_{name}") for name in COORDINATES]
    return found[which.reshape(-1)]

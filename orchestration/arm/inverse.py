"""Joint angles that bring the tool point to a place with the tool in the arm's own vertical plane.

The wrist does not roll then, and waist, shoulder, elbow and wrist pitch are a turn and a planar arm of two
links; closed form as in J. J. Craig, *Introduction to Robotics*, 3rd ed., chapter 4.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from warmlink.fmus.arm_kinematics.component import COMPONENT as KINEMATICS
from warmlink.orchestration.arm.geometry import axes
from warmlink.orchestration.arrays import Array


@cache
def _dimensions() -> tuple[float, ...]:
    """Column, upper arm, forearm and tool in m, out of the declaration of the arm's kinematics."""
    starts = {scalar.name: scalar.start or 0.0 for scalar in KINEMATICS.scalars()}
    return tuple(starts[f"link_{name}"] for name in ("offset[1]", "length[2]", "offset[4]", "offset[6]"))


def joint_angles(x: ArrayLike, y: ArrayLike, z: ArrayLike, pitch: float, roll: float = 0.0) -> Array:
    """Angles for tool points, elbow up.

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
    column, a, b, tool = _dimensions()
    x, y, z = (np.atleast_1d(np.asarray(each, dtype=float)) for each in (x, y, z))
    out = np.hypot(x, y) - tool * np.cos(pitch)
    up = z - tool * np.sin(pitch) - column
    reach = np.hypot(out, up)
    with np.errstate(invalid="ignore"):
        elbow = -np.arccos((reach**2 - a**2 - b**2) / (2 * a * b))
        upper = np.arctan2(up, out) - np.arctan2(b * np.sin(elbow), a + b * np.cos(elbow))
    angles = np.column_stack(
        [
            np.arctan2(y, x),
            upper - np.pi / 2,
            elbow,
            np.zeros_like(x),
            pitch - (upper + elbow),
            np.full_like(x, roll),
        ]
    )
    angles = np.where(np.isfinite(angles), (angles + np.pi) % (2 * np.pi) - np.pi, np.nan)
    limits = np.array([each.joint_limit for each in axes()])
    within = np.all(np.abs(angles) <= limits + 1e-9, axis=1)
    return np.where(within[:, None], angles, np.nan)
